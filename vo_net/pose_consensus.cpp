#include "vo_net/pose_consensus.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slam/base/random.hpp"
#include "vo_net/pose_layer_covariance.hpp"

namespace imslam::vo::detail {
namespace {

constexpr std::size_t kSampleSize = 3;
constexpr int kMostSamples = 400;
constexpr double kMissed = 0.01;  // probability that no sample lay within the largest group
constexpr int kIterations = 6;
constexpr double kDamping = 1e-6;
constexpr std::size_t kScoredPoints = 200;  // at most, evenly taken

struct Some {
  Correspondences correspondences;
  Estimate estimate;
};

Some select(const Problem& problem,
            const Estimate& start,
            const std::vector<std::size_t>& indices) {
  Some some;
  some.estimate.T_left0_left1 = start.T_left0_left1;
  for (const std::size_t i : indices) {
    some.correspondences.push_back(problem.correspondences[i]);
    some.estimate.disparities.push_back(start.disparities[i]);
  }
  return some;
}

/// The same without kernel, all points usable.
Problem plain(const Problem& problem, const Correspondences& correspondences) {
  return {correspondences,     problem.camera,
          RobustKernel::kNone, 1.0,
          problem.offset,      std::vector<char>(correspondences.size(), 1)};
}

/// The motion of a sample, or none.
std::optional<lie::SE3d> motion_of(const Problem& problem, Estimate estimate) {
  ReducedSystem system;
  for (int i = 0; i < kIterations; ++i) {
    build_system(problem, estimate, Model::kGaussNewton, kDamping, system);
    if (system.used < static_cast<int>(kSampleSize)) return std::nullopt;
    const Eigen::Matrix<double, 6, 6> H = system.H.topLeftCorner<6, 6>();
    const auto step = solve_positive(H, -system.g.head<6>());
    if (!step || !(step->norm() < 1.0)) return std::nullopt;  // [m, rad]
    estimate.T_left0_left1 = estimate.T_left0_left1 * lie::SE3d::exp(*step);
    ReducedVector reduced;
    reduced << *step, 0.0, 0.0;
    system.back_substitute(reduced, estimate.disparities);
  }
  return estimate.T_left0_left1;
}

struct Score {
  double cost = 0.0;
  double share = 0.0;
};

/// Of each point the least s that any disparity gives, to second order.
Score score_of(const Problem& problem, const Estimate& estimate, double limit) {
  ReducedSystem system;
  build_system(problem, estimate, Model::kGaussNewton, 0.0, system);
  Score score;
  for (const EliminatedPoint& point : system.points) {
    const double s =
        point.curvature > 0.0 ? point.s - point.gradient * point.gradient / point.curvature : limit;
    score.cost += std::min(s, limit);
    if (s < limit) score.share += 1.0 / static_cast<double>(system.points.size());
  }
  return score;
}

/// How many samples it takes if `share` of the points belong together.
double samples_needed(double share) {
  const double all_good = std::pow(share, kSampleSize);
  return all_good < 1.0 ? std::log(kMissed) / std::log1p(-all_good) : 1.0;
}

std::vector<std::size_t> every_nth(const std::vector<std::size_t>& all, std::size_t most) {
  const std::size_t step = (all.size() + most - 1) / most;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

}  // namespace

std::optional<Consensus> find_consensus(const Problem& problem,
                                        const Estimate& start,
                                        double limit) {
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < problem.usable.size(); ++i) {
    if (problem.usable[i] != 0) usable.push_back(i);
  }
  if (usable.size() < kSampleSize) return std::nullopt;
  Some judges = select(problem, start, every_nth(usable, kScoredPoints));
  const Problem judged = plain(problem, judges.correspondences);

  Random random(1);
  std::optional<Consensus> best;
  double least = 0.0;
  for (int i = 0; i < kMostSamples && !(best && i > samples_needed(best->share)); ++i) {
    std::vector<std::size_t> sample;
    while (sample.size() < kSampleSize) {
      const auto pick = random.integer(0, static_cast<std::int64_t>(usable.size()) - 1);
      const std::size_t index = usable[static_cast<std::size_t>(pick)];
      if (std::find(sample.begin(), sample.end(), index) == sample.end()) sample.push_back(index);
    }
    const Some some = select(problem, start, sample);
    const auto T_left0_left1 = motion_of(plain(problem, some.correspondences), some.estimate);
    if (!T_left0_left1) continue;
    judges.estimate.T_left0_left1 = *T_left0_left1;
    const Score score = score_of(judged, judges.estimate, limit);
    if (best && score.cost >= least) continue;
    least = score.cost;
    best = Consensus{{*T_left0_left1, start.disparities}, score.share};
  }
  return best;
}

}  // namespace imslam::vo::detail
