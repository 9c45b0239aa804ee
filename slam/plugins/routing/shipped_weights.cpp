#include "slam/nn/embedded_file.hpp"
#include "slam/plugins/routing/routing_weights.hpp"

// One file per number of agents; CMake defines the path of each that is there.
#define IMSLAM_ROUTE_WEIGHTS(agents, path)                   \
  IMSLAM_EMBED("imslam_route_weights_" #agents, path);       \
  extern "C" {                                               \
  extern const char imslam_route_weights_##agents##_begin[]; \
  extern const char imslam_route_weights_##agents##_end[];   \
  }
#define IMSLAM_ROUTE_BYTES(agents) \
  std::string(imslam_route_weights_##agents##_begin, imslam_route_weights_##agents##_end)

#ifdef IMSLAM_ROUTE_WEIGHTS_5
IMSLAM_ROUTE_WEIGHTS(5, IMSLAM_ROUTE_WEIGHTS_5)
#endif
#ifdef IMSLAM_ROUTE_WEIGHTS_10
IMSLAM_ROUTE_WEIGHTS(10, IMSLAM_ROUTE_WEIGHTS_10)
#endif
#ifdef IMSLAM_ROUTE_WEIGHTS_15
IMSLAM_ROUTE_WEIGHTS(15, IMSLAM_ROUTE_WEIGHTS_15)
#endif

namespace imslam::routing {

std::optional<std::string> shipped_weights(int agents) {
#ifdef IMSLAM_ROUTE_WEIGHTS_5
  if (agents == 5) return IMSLAM_ROUTE_BYTES(5);
#endif
#ifdef IMSLAM_ROUTE_WEIGHTS_10
  if (agents == 10) return IMSLAM_ROUTE_BYTES(10);
#endif
#ifdef IMSLAM_ROUTE_WEIGHTS_15
  if (agents == 15) return IMSLAM_ROUTE_BYTES(15);
#endif
  static_cast<void>(agents);
  return std::nullopt;
}

std::vector<int> shipped_agents() {
  std::vector<int> agents;
  for (const int count : {5, 10, 15}) {
    if (shipped_weights(count)) agents.push_back(count);
  }
  return agents;
}

}  // namespace imslam::routing
