// Prints whether the back end's covariances are the truth about its errors:
//   consistency_benchmark [RUNS [FRAMES [SEED]]]
#include <algorithm>
#include <cstdio>
#include <numeric>

#include "slam/base/text.hpp"
#include "tools/bench/consistency.hpp"

namespace {

void print(const char* name,
           const std::vector<double>& nees,
           double inside,
           imslam::bench::Band band) {
  const double mean =
      std::accumulate(nees.begin(), nees.end(), 0.0) / static_cast<double>(nees.size());
  std::printf("%-10s %10.3f   [%.3f, %.3f]   %12.1f %%\n", name, mean, band.low, band.high,
              100.0 * inside);
}

int argument(int argc, char** argv, int index, int fallback) {
  if (index >= argc) return fallback;
  return static_cast<int>(imslam::parse_int64(argv[index]).value_or(fallback));
}

}  // namespace

int main(int argc, char** argv) {
  using namespace imslam::bench;
  ConsistencyOptions options;
  options.runs = std::max(1, argument(argc, argv, 1, options.runs));
  options.frames = std::max(2, argument(argc, argv, 2, options.frames));
  options.seed = static_cast<std::uint64_t>(argument(argc, argv, 3, 1));
  const ConsistencyResult result = study_consistency(options);
  std::printf("%d runs of %d frames, VO at %.0f Hz and IMU at %.0f Hz\n", options.runs,
              options.frames, options.frame_rate_hz, options.imu_rate_hz);
  std::printf("            mean NEES      95 %% band      steps inside\n");
  print("pose", result.pose_nees, result.pose_inside, average_nees_band(6, options.runs));
  print("velocity", result.velocity_nees, result.velocity_inside,
        average_nees_band(3, options.runs));

  options.runs = 1;
  options.noise = 0.0;
  std::printf("noise-free measurements: largest position error %.2e m\n",
              study_consistency(options).largest_position_error_m);
  return 0;
}
