#include "imu_net/imu_weights.hpp"
#include "slam/nn/embedded_file.hpp"

#ifdef IMSLAM_IMU_WEIGHTS
IMSLAM_EMBED("imslam_imu_weights", IMSLAM_IMU_WEIGHTS);
extern "C" {
extern const char imslam_imu_weights_begin[];
extern const char imslam_imu_weights_end[];
}
#endif

namespace imslam::imu {

std::optional<std::string> shipped_imu_weights() {
#ifdef IMSLAM_IMU_WEIGHTS
  return std::string(imslam_imu_weights_begin, imslam_imu_weights_end);
#else
  return std::nullopt;
#endif
}

}  // namespace imslam::imu
