#include "slam/evaluation/motion_consistency.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "slam/base/time.hpp"

namespace imslam::evaluation {
namespace {

constexpr double kSameTime = 1e-3;                 // [s]
constexpr double kChiSquare6Quantile95 = 12.5916;  // of 6 degrees of freedom

std::optional<lie::SE3d> truth_at(const PosePath& truth, std::int64_t time_ns) {
  const double time_s = static_cast<double>(time_ns) / kNanosecondsPerSecond;
  const auto& stamps = truth.stamps_s;
  const auto after = std::lower_bound(stamps.begin(), stamps.end(), time_s - kSameTime);
  std::optional<std::size_t> nearest;
  for (auto it = after; it != stamps.end() && *it <= time_s + kSameTime; ++it) {
    const auto i = static_cast<std::size_t>(it - stamps.begin());
    if (!nearest || std::abs(*it - time_s) < std::abs(stamps[*nearest] - time_s)) nearest = i;
  }
  if (!nearest) return std::nullopt;
  return lie::SE3d::from_matrix(truth.poses[*nearest]);
}

double squared_norm(const Eigen::Ref<const Eigen::MatrixXd>& covariance,
                    const Eigen::Ref<const Eigen::VectorXd>& error) {
  return error.dot(covariance.ldlt().solve(error));
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

std::optional<MotionConsistency> motion_consistency(const std::vector<RelativeMotion>& motions,
                                                    const PosePath& truth,
                                                    const lie::SE3d& T_body_truth) {
  if (!truth.has_stamps()) return std::nullopt;
  const lie::SE3d T_truth_body = T_body_truth.inverse();
  std::vector<double> whole;
  std::vector<double> translation;
  std::vector<double> rotation;
  for (const RelativeMotion& motion : motions) {
    const auto T_world_truth0 = truth_at(truth, motion.time0_ns);
    const auto T_world_truth1 = truth_at(truth, motion.time1_ns);
    if (!motion.valid || !T_world_truth0 || !T_world_truth1) continue;
    const lie::SE3d T_body0_body1 =
        T_body_truth * T_world_truth0->inverse() * *T_world_truth1 * T_truth_body;
    const Eigen::Matrix<double, 6, 1> error =
        (motion.T_body0_body1.inverse() * T_body0_body1).log();
    whole.push_back(squared_norm(motion.covariance, error));
    translation.push_back(squared_norm(motion.covariance.topLeftCorner<3, 3>(), error.head<3>()));
    rotation.push_back(squared_norm(motion.covariance.bottomRightCorner<3, 3>(), error.tail<3>()));
  }
  if (whole.empty()) return std::nullopt;
  MotionConsistency result;
  result.motions = whole.size();
  result.nees_mean = mean(whole);
  result.nees_translation_mean = mean(translation);
  result.nees_rotation_mean = mean(rotation);
  const auto inside = std::count_if(whole.begin(), whole.end(),
                                    [](double nees) { return nees < kChiSquare6Quantile95; });
  result.share_inside = static_cast<double>(inside) / static_cast<double>(whole.size());
  const auto middle = whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2);
  std::nth_element(whole.begin(), middle, whole.end());
  result.nees_median = *middle;
  return result;
}

}  // namespace imslam::evaluation
