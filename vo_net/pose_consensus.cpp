#include "vo_net/pose_consensus.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "slam/base/random.hpp"
#include "vo_net/pose_layer_covariance.hpp"

namespace imslam::vo::detail {
namespace {

constexpr std::size_t kSampleSize = 3;
constexpr int kMostSamples = 400;
constexpr double kMissed = 0.01;  // probability that no sample lay within the largest group
constexpr int kIterations = 6;
constexpr double kDamping = 1e-6;
// Beyond, a sample diverges; from a standing start a fast car takes steps of metres.
constexpr double kLargestStep_m = 10.0;
constexpr double kLargestStep_rad = 1.0;
constexpr std::size_t kScoredPoints = 200;  // at most, evenly taken
constexpr double kClose_px = 2.0;       // how well a point of the group fits, at an exact rotation
constexpr double kContradiction = 4.0;  // standard deviations of what was foretold
constexpr double kLeastDisparity_px = 0.5;  // farther points say nothing of the translation

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
    const bool sane = step && step->head<3>().norm() < kLargestStep_m &&
                      step->tail<3>().norm() < kLargestStep_rad;
    if (!sane) return std::nullopt;
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

/// One point as both pairs see it, with the disparities that were measured.
struct SeenTwice {
  Eigen::Vector3d p_left0;
  Eigen::Vector3d p_left1;
  Eigen::Vector3d uvd1;
};

std::vector<SeenTwice> seen_twice(const Problem& problem) {
  std::vector<SeenTwice> seen;
  for (std::size_t i = 0; i < problem.usable.size(); ++i) {
    const Correspondence& c = problem.correspondences[i];
    const double d0 = c.disparity0 - problem.offset;
    const double d1 = c.disparity1 - problem.offset;
    if (problem.usable[i] == 0 || !(d0 > kLeastDisparity_px) || !(d1 > kLeastDisparity_px))
      continue;
    const Eigen::Vector3d uvd1(c.left1.x(), c.left1.y(), d1);
    seen.push_back({problem.camera.back_project({c.left0.x(), c.left0.y(), d0}),
                    problem.camera.back_project(uvd1), uvd1});
  }
  return seen;
}

/// [px^2] of one point under a motion, both in the image and in disparity.
double square_error(const SeenTwice& point,
                    const lie::SE3d& T_left1_left0,
                    const StereoCamera& camera) {
  const Eigen::Vector3d p = T_left1_left0 * point.p_left0;
  if (!(p.z() > 0.0)) return std::numeric_limits<double>::infinity();
  return (camera.project(p) - point.uvd1).squaredNorm();
}

}  // namespace

bool Foretold::turns_alike(const lie::SE3d& T_left0_left1_seen) const {
  const lie::SO3d off = T_left0_left1.rotation().inverse() * T_left0_left1_seen.rotation();
  return off.log().norm() < kContradiction * sigma_rad;
}

bool Foretold::moves_alike(const lie::SE3d& T_left0_left1_seen) const {
  const Eigen::Vector3d off = T_left0_left1.translation() - T_left0_left1_seen.translation();
  return !translation_known || off.norm() < kContradiction * sigma_m;
}

std::optional<Consensus> find_foretold(const Problem& problem,
                                       const Estimate& start,
                                       const Foretold& foretold) {
  const std::vector<SeenTwice> all = seen_twice(problem);
  if (all.size() < kSampleSize) return std::nullopt;
  const std::size_t step = (all.size() + kScoredPoints - 1) / kScoredPoints;
  const double close_px = kClose_px + 2.0 * foretold.sigma_rad * problem.camera.fx;
  const double limit = close_px * close_px;
  const lie::SO3d R_left0_left1 = foretold.T_left0_left1.rotation();
  std::optional<lie::SE3d> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < all.size(); k += step) {
    const lie::SE3d T_left0_left1(R_left0_left1, all[k].p_left0 - R_left0_left1 * all[k].p_left1);
    if (!foretold.moves_alike(T_left0_left1)) continue;
    const lie::SE3d T_left1_left0 = T_left0_left1.inverse();
    double cost = 0.0;
    for (std::size_t j = 0; j < all.size() && cost < least; j += step) {
      cost += std::min(square_error(all[j], T_left1_left0, problem.camera), limit);
    }
    if (cost >= least) continue;
    least = cost;
    best = T_left0_left1;
  }
  if (!best) return std::nullopt;
  const lie::SE3d T_left1_left0 = best->inverse();
  const auto alike = std::count_if(all.begin(), all.end(), [&](const SeenTwice& point) {
    return square_error(point, T_left1_left0, problem.camera) < limit;
  });
  return Consensus{{*best, start.disparities},
                   static_cast<double>(alike) / static_cast<double>(all.size())};
}

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
