#include "datasets/scale_comparison.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

constexpr double kSpan_s = 0.4;      ///< over which mean velocities are taken
constexpr double kLongest_s = 10.0;  ///< of a stretch: orientation drifts
constexpr double kMaxStep_s = 0.15;  ///< between frames
constexpr double kMaxImuGap_s = 0.05;
constexpr int kMinMoments = 30;
constexpr int kShared = 4;  ///< unknowns of all stretches: scale and scaled bias

/// An unbroken piece of the recording, at its frames; `world` is the body at its first frame.
struct Stretch {
  std::vector<double> times_s;             ///< since the first frame
  std::vector<lie::SO3d> R_world_body;     ///< as seen by vision
  std::vector<Eigen::Vector3d> seen;       ///< [m] u: path of the camera, scaled
  std::vector<Eigen::Vector3d> lever;      ///< [m] l: path of the body about the camera
  std::vector<Eigen::Vector3d> integral;   ///< [m] of the rotated specific force, twice
  std::vector<Eigen::Vector3d> force_sum;  ///< [m/s] likewise, once
};

/// One moment's three equations: seen = scale (gravity + known) - R (scale bias).
struct Moment {
  std::size_t stretch = 0;
  Eigen::Vector3d seen;   ///< [m/s^2] D(u)
  Eigen::Vector3d known;  ///< [m/s^2] D(integral) - D(l)
  Eigen::Matrix3d R;
};

/// Adds the frame at the end of `motion`; false if the IMU does not cover it.
bool extend(Stretch& stretch,
            const VisualRotation& motion,
            const std::vector<ImuSample>& imu,
            const lie::SE3d& T_body_left,
            std::int64_t offset_ns) {
  const lie::SO3d& R_body_left = T_body_left.rotation();
  const lie::SO3d R_left0_left1 = lie::SO3d::exp(motion.log_left0_left1);
  const lie::SO3d R_body0_body1 = R_body_left * R_left0_left1 * R_body_left.inverse();
  const std::int64_t start_ns = motion.time0_ns + offset_ns;
  const std::int64_t end_ns = motion.time1_ns + offset_ns;
  auto after = std::upper_bound(imu.begin(), imu.end(), start_ns,
                                [](std::int64_t t, const ImuSample& s) { return t < s.time_ns; });
  if (after == imu.begin()) return false;
  const lie::SO3d R0 = stretch.R_world_body.back();
  const Eigen::Vector3d turn = R_body0_body1.log() / to_seconds(end_ns - start_ns);
  Eigen::Vector3d velocity = stretch.force_sum.back();
  Eigen::Vector3d position = stretch.integral.back();
  for (std::int64_t t = start_ns; t < end_ns; ++after) {
    if (after == imu.end()) return false;
    const ImuSample& before = *(after - 1);
    const double step_s = to_seconds(after->time_ns - before.time_ns);
    if (step_s > kMaxImuGap_s) return false;
    const std::int64_t until = std::min(after->time_ns, end_ns);
    const double h = to_seconds(until - t);
    const double middle_s = to_seconds(t - start_ns) + 0.5 * h;
    const double share = (to_seconds(t - before.time_ns) + 0.5 * h) / step_s;
    const Eigen::Vector3d force =
        (1.0 - share) * before.linear_acceleration + share * after->linear_acceleration;
    const Eigen::Vector3d pull = R0 * (lie::SO3d::exp(turn * middle_s) * force);
    position += velocity * h + 0.5 * h * h * pull;
    velocity += h * pull;
    t = until;
  }
  const lie::SO3d R1 = R0 * R_body0_body1;
  stretch.times_s.push_back(stretch.times_s.back() + to_seconds(end_ns - start_ns));
  stretch.seen.emplace_back(stretch.seen.back() + R0 * (R_body_left * motion.t_left0_left1));
  stretch.lever.emplace_back(R1 * Eigen::Vector3d(-T_body_left.translation()));
  stretch.R_world_body.push_back(R1);
  stretch.integral.push_back(position);
  stretch.force_sum.push_back(velocity);
  return true;
}

Stretch begin_stretch(const lie::SE3d& T_body_left) {
  Stretch stretch;
  stretch.times_s = {0.0};
  stretch.R_world_body = {lie::SO3d()};
  stretch.seen = {Eigen::Vector3d::Zero()};
  stretch.lever = {Eigen::Vector3d(-T_body_left.translation())};
  stretch.integral = {Eigen::Vector3d::Zero()};
  stretch.force_sum = {Eigen::Vector3d::Zero()};
  return stretch;
}

/// Where the body is about the camera: p_body = p_left - R t_body_left, up to a constant.
std::vector<Stretch> stretches_of(const std::vector<VisualRotation>& vision,
                                  const std::vector<ImuSample>& imu,
                                  const lie::SE3d& T_body_left,
                                  std::int64_t offset_ns) {
  std::vector<Stretch> stretches;
  bool open = false;
  for (std::size_t k = 0; k < vision.size(); ++k) {
    const double step_s = to_seconds(vision[k].time1_ns - vision[k].time0_ns);
    const bool contiguous = k > 0 && vision[k].time0_ns == vision[k - 1].time1_ns;
    open = open && contiguous && stretches.back().times_s.back() < kLongest_s;
    if (step_s > kMaxStep_s) {
      open = false;
      continue;
    }
    if (!open) stretches.push_back(begin_stretch(T_body_left));
    open = extend(stretches.back(), vision[k], imu, T_body_left, offset_ns);
  }
  return stretches;
}

/// Difference of the mean velocities over [i, j] and [j, k], per second.
Eigen::Vector3d second_difference(const std::vector<Eigen::Vector3d>& p,
                                  const std::vector<double>& t,
                                  std::size_t i,
                                  std::size_t j,
                                  std::size_t k) {
  return 2.0 / (t[k] - t[i]) * ((p[k] - p[j]) / (t[k] - t[j]) - (p[j] - p[i]) / (t[j] - t[i]));
}

std::vector<Moment> moments_of(const std::vector<Stretch>& stretches) {
  std::vector<Moment> moments;
  for (std::size_t s = 0; s < stretches.size(); ++s) {
    const Stretch& stretch = stretches[s];
    const auto& t = stretch.times_s;
    const auto reach = [&](std::size_t from) {
      std::size_t to = from + 1;
      while (to < t.size() && t[to] - t[from] < kSpan_s - 1e-6) ++to;
      return to;
    };
    for (std::size_t i = 0; i < t.size(); ++i) {
      const std::size_t j = reach(i);
      const std::size_t k = reach(j);
      if (j >= t.size() || k >= t.size()) break;
      moments.push_back({s, second_difference(stretch.seen, t, i, j, k),
                         second_difference(stretch.integral, t, i, j, k) -
                             second_difference(stretch.lever, t, i, j, k),
                         stretch.R_world_body[j].matrix()});
    }
  }
  return moments;
}

/// Least squares for [scale, scale b, scale g of each stretch].
struct Fit {
  Eigen::VectorXd x;
  double scale_variance = 0.0;  ///< times the variance of an equation
  std::vector<double> residuals;
};

Eigen::Matrix<double, 3, kShared> shared_columns(const Moment& moment) {
  Eigen::Matrix<double, 3, kShared> columns;
  columns << moment.known, -moment.R;
  return columns;
}

Fit fit(const std::vector<Moment>& moments, std::size_t stretches) {
  const auto unknowns = static_cast<Eigen::Index>(kShared + 3 * stretches);
  Eigen::MatrixXd H = 1e-9 * Eigen::MatrixXd::Identity(unknowns, unknowns);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(unknowns);
  const auto columns_of = [&](const Moment& moment) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, unknowns);
    J.leftCols<kShared>() = shared_columns(moment);
    J.middleCols<3>(static_cast<Eigen::Index>(kShared + 3 * moment.stretch)).setIdentity();
    return J;
  };
  for (const Moment& moment : moments) {
    const Eigen::MatrixXd J = columns_of(moment);
    H += J.transpose() * J;
    g += J.transpose() * moment.seen;
  }
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(H);
  Fit result;
  result.x = ldlt.solve(g);
  result.scale_variance = ldlt.solve(Eigen::VectorXd::Unit(unknowns, 0))(0);
  for (const Moment& moment : moments) {
    result.residuals.push_back((columns_of(moment) * result.x - moment.seen).norm());
  }
  return result;
}

/// Those whose residual is at most four times the median one.
std::vector<Moment> inliers(const std::vector<Moment>& moments, const Fit& fit) {
  std::vector<double> sorted = fit.residuals;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double limit = 4.0 * sorted[sorted.size() / 2];
  std::vector<Moment> kept;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    if (fit.residuals[i] <= limit) kept.push_back(moments[i]);
  }
  return kept;
}

}  // namespace

ScaleComparison compare_scale(const std::vector<VisualRotation>& vision,
                              const std::vector<ImuSample>& imu,
                              const lie::SE3d& T_body_left,
                              double time_offset_s) {
  ScaleComparison result;
  const auto stretches = stretches_of(vision, imu, T_body_left, to_nanoseconds(time_offset_s));
  std::vector<Moment> moments = moments_of(stretches);
  if (static_cast<int>(moments.size()) < kMinMoments) return result;
  moments = inliers(moments, fit(moments, stretches.size()));
  const Fit found = fit(moments, stretches.size());
  double square = 0.0;
  for (const double residual : found.residuals) square += residual * residual;
  const auto count = static_cast<double>(moments.size());
  // Moments overlap: of those within a span only one is new.
  const double step_s = to_seconds(vision.front().time1_ns - vision.front().time0_ns);
  const double overlap = std::max(1.0, kSpan_s / std::max(1e-3, step_s));
  result.moments = static_cast<int>(moments.size());
  result.scale = found.x(0);
  result.sigma = std::sqrt(found.scale_variance * square / (3.0 * count) * overlap);
  result.excitation = std::sqrt(1.0 / std::max(1e-12, found.scale_variance * 3.0 * count));
  double gravity = 0.0;
  for (const Moment& moment : moments) {
    gravity += found.x.segment<3>(static_cast<Eigen::Index>(kShared + 3 * moment.stretch)).norm();
  }
  result.gravity = gravity / count / std::max(1e-6, std::abs(result.scale));
  result.valid =
      result.moments >= kMinMoments && result.scale > 0.0 && result.sigma < 0.1 * result.scale;
  return result;
}

}  // namespace imslam::datasets
