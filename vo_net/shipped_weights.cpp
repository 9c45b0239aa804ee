#include "slam/nn/embedded_file.hpp"
#include "vo_net/match_weights.hpp"
#include "vo_net/pose_head_weights.hpp"

#ifdef IMSLAM_MATCH_WEIGHTS
IMSLAM_EMBED("imslam_match_weights", IMSLAM_MATCH_WEIGHTS);
extern "C" {
extern const char imslam_match_weights_begin[];
extern const char imslam_match_weights_end[];
}
#endif

#ifdef IMSLAM_POSE_HEAD_WEIGHTS
IMSLAM_EMBED("imslam_pose_head_weights", IMSLAM_POSE_HEAD_WEIGHTS);
extern "C" {
extern const char imslam_pose_head_weights_begin[];
extern const char imslam_pose_head_weights_end[];
}
#endif

namespace imslam::vo {

std::optional<std::string> shipped_match_weights() {
#ifdef IMSLAM_MATCH_WEIGHTS
  return std::string(imslam_match_weights_begin, imslam_match_weights_end);
#else
  return std::nullopt;
#endif
}

std::optional<std::string> shipped_pose_head() {
#ifdef IMSLAM_POSE_HEAD_WEIGHTS
  return std::string(imslam_pose_head_weights_begin, imslam_pose_head_weights_end);
#else
  return std::nullopt;
#endif
}

}  // namespace imslam::vo
