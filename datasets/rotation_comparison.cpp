#include "datasets/rotation_comparison.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

constexpr double kMaxOffset_s = 0.15;
constexpr double kCoarseStep_s = 0.005;
constexpr double kFineStep_s = 0.001;
constexpr double kMaxGap_s = 0.05;
constexpr std::size_t kMinIntervals = 20;
constexpr double kMinAngle_rad = 0.26;  // 15 degrees

/// C(t) = integral of the angular velocity up to t, linear between samples. Over one camera
/// interval the difference of two values is the rotation vector up to second-order coning.
class GyroIntegral {
 public:
  explicit GyroIntegral(const std::vector<ImuSample>& samples) : samples_(samples) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (i > 0) {
        sum += 0.5 * to_seconds(samples[i].time_ns - samples[i - 1].time_ns) *
               (samples[i].angular_velocity + samples[i - 1].angular_velocity);
      }
      sums_.push_back(sum);
    }
  }

  /// Empty outside of the samples and inside of gaps.
  std::optional<Eigen::Vector3d> at(std::int64_t time_ns) const {
    const auto after =
        std::upper_bound(samples_.begin(), samples_.end(), time_ns,
                         [](std::int64_t t, const ImuSample& s) { return t < s.time_ns; });
    if (after == samples_.begin() || after == samples_.end()) return std::nullopt;
    const auto i = static_cast<std::size_t>(after - samples_.begin()) - 1;
    const double step_s = to_seconds(samples_[i + 1].time_ns - samples_[i].time_ns);
    if (step_s > kMaxGap_s) return std::nullopt;
    const double dt_s = to_seconds(time_ns - samples_[i].time_ns);
    const Eigen::Vector3d& w0 = samples_[i].angular_velocity;
    const Eigen::Vector3d& w1 = samples_[i + 1].angular_velocity;
    return sums_[i] + dt_s * w0 + 0.5 * dt_s * dt_s / step_s * (w1 - w0);
  }

 private:
  const std::vector<ImuSample>& samples_;
  std::vector<Eigen::Vector3d> sums_;
};

/// Rotation vectors of the same intervals, 3 x n, mean removed (a gyro bias is such a mean).
struct Pairs {
  Eigen::Matrix3Xd vision;  ///< in the left camera
  Eigen::Matrix3Xd gyro;    ///< in the body
  std::vector<std::size_t> index;
};

Pairs pairs_at(const std::vector<VisualRotation>& vision,
               const GyroIntegral& gyro,
               const std::vector<bool>& used,
               double offset_s) {
  const std::int64_t offset_ns = to_nanoseconds(offset_s);
  Pairs pairs;
  std::vector<Eigen::Vector3d> turns;
  for (std::size_t k = 0; k < vision.size(); ++k) {
    if (!used[k]) continue;
    const auto start = gyro.at(vision[k].time0_ns + offset_ns);
    const auto end = gyro.at(vision[k].time1_ns + offset_ns);
    if (!start || !end) continue;
    pairs.index.push_back(k);
    turns.emplace_back(*end - *start);
  }
  const auto count = static_cast<Eigen::Index>(turns.size());
  pairs.vision.resize(3, count);
  pairs.gyro.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double dt_s =
        to_seconds(vision[pairs.index[k]].time1_ns - vision[pairs.index[k]].time0_ns);
    pairs.vision.col(i) = vision[pairs.index[k]].log_left0_left1 / dt_s;
    pairs.gyro.col(i) = turns[k] / dt_s;
  }
  if (count > 0) {
    pairs.vision.colwise() -= Eigen::Vector3d(pairs.vision.rowwise().mean());
    pairs.gyro.colwise() -= Eigen::Vector3d(pairs.gyro.rowwise().mean());
  }
  return pairs;
}

double correlation(const Pairs& pairs, const Eigen::Matrix3d& R_left_body) {
  const double norm = pairs.vision.norm() * pairs.gyro.norm();
  return norm > 0.0 ? pairs.vision.cwiseProduct(R_left_body * pairs.gyro).sum() / norm : 0.0;
}

/// Rotation that maximises the correlation (Kabsch).
Eigen::Matrix3d best_rotation(const Pairs& pairs) {
  const Eigen::Matrix3d M = pairs.vision * pairs.gyro.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1.0, 1.0, 1.0);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs.z() = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

/// Second over first singular value: 0 if all turns are about one axis.
double planarity_of(const Eigen::Matrix3Xd& turns) {
  const Eigen::Matrix3d moment = turns * turns.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> squares(moment);
  const Eigen::Vector3d lengths = squares.singularValues().cwiseSqrt();
  return lengths(1) / std::max(1e-12, lengths(0));
}

struct Peak {
  double offset_s = 0.0;
  double value = -1.0;
};

/// Largest value of f over +-0.15 s: coarse grid, fine grid, parabola through the three best.
template <typename Function>
Peak find_peak(const Function& f) {
  Peak peak;
  const auto scan = [&](double center, double reach, double step) {
    const int count = static_cast<int>(std::lround(reach / step));
    for (int i = -count; i <= count; ++i) {
      const double value = f(center + i * step);
      if (value > peak.value) peak = {center + i * step, value};
    }
  };
  scan(0.0, kMaxOffset_s, kCoarseStep_s);
  scan(peak.offset_s, kCoarseStep_s, kFineStep_s);
  const double before = f(peak.offset_s - kFineStep_s);
  const double after = f(peak.offset_s + kFineStep_s);
  const double curvature = before - 2.0 * peak.value + after;
  if (curvature < 0.0) {
    peak.offset_s += std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0) * kFineStep_s;
  }
  return peak;
}

/// Intervals whose residual is at most four times the median one.
std::vector<bool> inliers(const Pairs& pairs, const Eigen::Matrix3d& R, std::size_t count) {
  const double scale =
      pairs.vision.cwiseProduct(R * pairs.gyro).sum() / std::max(1e-12, pairs.gyro.squaredNorm());
  const Eigen::VectorXd residuals = (pairs.vision - scale * R * pairs.gyro).colwise().norm();
  std::vector<double> sorted(residuals.data(), residuals.data() + residuals.size());
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double limit = 4.0 * sorted[sorted.size() / 2];
  std::vector<bool> used(count, false);
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    used[pairs.index[static_cast<std::size_t>(i)]] = residuals[i] <= limit;
  }
  return used;
}

/// Vision over gyro, over sums of kWindow adjacent intervals: recorders that interpolate or filter
/// the gyro flatten its fast part, which must not look like a wrong focal length.
double scale_of(const Pairs& pairs,
                const std::vector<VisualRotation>& vision,
                const Eigen::Matrix3d& R) {
  constexpr Eigen::Index kWindow = 5;
  double product = 0.0;
  double square = 0.0;
  for (Eigen::Index i = 0; i + kWindow <= pairs.vision.cols(); ++i) {
    bool adjacent = true;
    for (Eigen::Index k = i + 1; k < i + kWindow; ++k) {
      const auto here = pairs.index[static_cast<std::size_t>(k)];
      const auto before = pairs.index[static_cast<std::size_t>(k - 1)];
      adjacent = adjacent && vision[here].time0_ns == vision[before].time1_ns;
    }
    if (!adjacent) continue;
    const Eigen::Vector3d v = pairs.vision.middleCols<kWindow>(i).rowwise().sum();
    const Eigen::Vector3d g = R * pairs.gyro.middleCols<kWindow>(i).rowwise().sum();
    product += v.dot(g);
    square += g.squaredNorm();
  }
  if (square > 0.0) return product / square;
  return pairs.vision.cwiseProduct(R * pairs.gyro).sum() /
         std::max(1e-12, pairs.gyro.squaredNorm());
}

}  // namespace

RotationComparison compare_rotations(const std::vector<VisualRotation>& vision,
                                     const std::vector<ImuSample>& imu,
                                     const lie::SO3d& R_body_left) {
  RotationComparison result;
  if (vision.size() < kMinIntervals || imu.size() < 2) return result;
  const GyroIntegral gyro(imu);
  std::vector<bool> used(vision.size(), true);
  Peak peak;
  Pairs pairs;
  const auto free = [&](double offset_s) {
    const Pairs at = pairs_at(vision, gyro, used, offset_s);
    return at.index.size() < kMinIntervals ? -1.0 : correlation(at, best_rotation(at));
  };
  for (int round = 0; round < 2; ++round) {
    peak = find_peak(free);
    pairs = pairs_at(vision, gyro, used, peak.offset_s);
    if (pairs.index.size() < kMinIntervals) return result;
    if (round == 0) used = inliers(pairs, best_rotation(pairs), vision.size());
  }
  const auto calibrated = [&](const lie::SO3d& R_left_body) {
    const Eigen::Matrix3d R = R_left_body.matrix();
    return find_peak([&](double offset_s) {
             const Pairs at = pairs_at(vision, gyro, used, offset_s);
             return at.index.size() < kMinIntervals ? -1.0 : correlation(at, R);
           })
        .value;
  };
  const Eigen::Matrix3d R = best_rotation(pairs);
  result.intervals = static_cast<int>(pairs.index.size());
  for (std::size_t i = 0; i < pairs.index.size(); ++i) {
    const VisualRotation& interval = vision[pairs.index[i]];
    result.angle_rad += pairs.gyro.col(static_cast<Eigen::Index>(i)).norm() *
                        to_seconds(interval.time1_ns - interval.time0_ns);
  }
  result.time_offset_s = peak.offset_s;
  result.correlation = peak.value;
  result.calibrated = calibrated(R_body_left.inverse());
  result.inverted = calibrated(R_body_left);
  result.scale = scale_of(pairs, vision, R);
  result.planarity = planarity_of(pairs.gyro);
  result.R_left_body = lie::SO3d::from_matrix(R);
  result.valid = result.angle_rad > kMinAngle_rad && result.correlation > 0.5;
  return result;
}

}  // namespace imslam::datasets
