#include "slam/system/front_end.hpp"

#include <utility>

#include "vo_net/klt_matcher.hpp"
#include "vo_net/learned_matcher.hpp"
#include "vo_net/match_weights.hpp"

namespace imslam::system {

FrontEnd make_front_end(const SlamOptions& options, const StereoCamera& camera) {
  FrontEnd front_end;
  if (options.system.front_end == "klt") {
    front_end.matcher = std::make_unique<vo::KltMatcher>(options.vo.klt, camera);
    return front_end;
  }
  vo::TrainedMatchNetwork trained = vo::load_match_network(options.vo.learned.weights);
  front_end.matcher =
      std::make_unique<vo::LearnedMatcher>(options.vo.learned, camera, std::move(trained.network));
  front_end.models.push_back({"match_network", std::move(trained.file), std::move(trained.card)});
  return front_end;
}

}  // namespace imslam::system
