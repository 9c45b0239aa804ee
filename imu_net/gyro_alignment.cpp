#include "imu_net/gyro_alignment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "imu_net/option_bounds.hpp"
#include "slam/base/config.hpp"

namespace imslam::imu {
namespace {

using lie::SO3d;
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

constexpr double kChi3ToStd = 1.5382;  ///< median of |x| for a unit normal x in three dimensions
constexpr double kInlierWidth = 3.0;   ///< robust standard deviations, per axis
constexpr double kStepTolerance =
    1e-6;  ///< square of a step in the standard deviations of the result

/// One motion's residual, whitened, with its Jacobian.
struct Residual {
  Eigen::Vector3d raw, white;
  Eigen::Matrix<double, 3, 7> J;   ///< of `white`
  double false_information = 0.0;  ///< on the time offset, of the gyro's noise in J
};

class Fit {
 public:
  Fit(const std::vector<RelativeMotion>& vision,
      ImuRange samples,
      const ImuNoise& noise,
      const GyroAlignmentOptions& options)
      : vision_(vision), samples_(samples), noise_(noise), options_(options) {}

  std::optional<GyroAlignment> run(double time_offset_s);

 private:
  std::vector<Residual> residuals() const;
  std::optional<Residual> residual(const RelativeMotion& motion) const;
  double scale_of(const std::vector<Residual>& residuals) const;
  Matrix7d information(const std::vector<Residual>& residuals,
                       double scale,
                       bool final,
                       Vector7d* slope) const;
  void step(const Vector7d& delta);
  void report(const std::vector<Residual>& residuals, double scale);

  const std::vector<RelativeMotion>& vision_;
  ImuRange samples_;
  const ImuNoise& noise_;
  const GyroAlignmentOptions& options_;
  GyroAlignment state_;
};

std::optional<Residual> Fit::residual(const RelativeMotion& motion) const {
  if (!motion.valid || motion.time1_ns <= motion.time0_ns) return std::nullopt;
  const ImuBias bias{state_.gyro_bias, Eigen::Vector3d::Zero()};
  const ImuMotion imu =
      preintegrate(samples_, motion.time0_ns, motion.time1_ns, bias, noise_, state_.time_offset_s);
  if (!imu.valid || imu.degraded) return std::nullopt;
  const SO3d mounting = SO3d::exp(state_.rotation_correction);
  const SO3d turned = mounting * motion.T_body0_body1.rotation() * mounting.inverse();
  Residual r;
  r.raw = (imu.dR.inverse() * turned).log();

  Eigen::Matrix3d covariance = motion.covariance.bottomRightCorner<3, 3>();
  covariance += imu.covariance.topLeftCorner<3, 3>();
  covariance.diagonal().array() += options_.vision_rotation_floor * options_.vision_rotation_floor;
  const Eigen::LLT<Eigen::Matrix3d> root(covariance);
  if (!r.raw.allFinite() || !covariance.allFinite() || root.info() != Eigen::Success) {
    return std::nullopt;
  }
  const Eigen::Matrix3d J_left_inverse = SO3d::left_jacobian_inverse(r.raw);
  Eigen::Matrix<double, 3, 7> J;
  J.leftCols<3>() = -J_left_inverse * imu.J_dR_bias.leftCols<3>();
  J.col(3) = -J_left_inverse * imu.J_time_offset.head<3>();
  J.rightCols<3>() = SO3d::right_jacobian_inverse(r.raw) *
                     (turned.matrix().transpose() - Eigen::Matrix3d::Identity());
  if (!options_.estimate_time_offset) J.col(3).setZero();
  if (!options_.estimate_rotation) J.rightCols<3>().setZero();
  r.white = root.matrixL().solve(r.raw);
  r.J = root.matrixL().solve(J);
  // What the readings say themselves of their noise is in the covariance, too.
  const double density_sq = imu.covariance.topLeftCorner<3, 3>().trace() / (3.0 * imu.dt_s);
  const Eigen::Matrix3d whitener = root.matrixL().solve(Eigen::Matrix3d::Identity());
  r.false_information = 2.0 * density_sq * noise_.rate_hz * whitener.squaredNorm();
  return r;
}

std::vector<Residual> Fit::residuals() const {
  std::vector<Residual> result;
  for (const RelativeMotion& motion : vision_) {
    if (const auto r = residual(motion)) result.push_back(*r);
  }
  return result;
}

/// Vision's covariances may be off by a factor: the median length of the residuals tells it.
double Fit::scale_of(const std::vector<Residual>& residuals) const {
  std::vector<double> lengths;
  for (const Residual& r : residuals) lengths.push_back(r.white.norm());
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return std::max(*middle / kChi3ToStd, 1e-9);
}

Matrix7d Fit::information(const std::vector<Residual>& residuals,
                          double scale,
                          bool final,
                          Vector7d* slope) const {
  Matrix7d H = Matrix7d::Zero();
  double false_information = 0.0;
  slope->setZero();
  for (const Residual& r : residuals) {
    const double length = r.white.norm() / (scale * std::sqrt(3.0));
    const double weight = std::min(1.0, options_.robust_width / length) / (scale * scale);
    H += weight * r.J.transpose() * r.J;
    *slope += weight * r.J.transpose() * r.white;
    false_information += weight * r.false_information;
  }
  if (final && H(3, 3) > 0.0) {
    // At rest the noise of the rates looks like motion and would feign a sharp time offset.
    const double share = std::sqrt(std::max(0.0, 1.0 - false_information / H(3, 3)));
    H.row(3) *= share;
    H.col(3) *= share;
  }
  // Weak priors about zero: they decide only where the motion says nothing.
  const double offset_information = 1.0 / std::pow(options_.time_offset_prior_s, 2);
  const double rotation_information = 1.0 / std::pow(options_.rotation_prior, 2);
  H(3, 3) += offset_information;
  (*slope)(3) += options_.estimate_time_offset ? offset_information * state_.time_offset_s : 0.0;
  for (int i = 0; i < 3; ++i) {
    H(4 + i, 4 + i) += rotation_information;
    (*slope)(4 + i) += rotation_information * state_.rotation_correction(i);
  }
  return H;
}

void Fit::step(const Vector7d& delta) {
  state_.gyro_bias += delta.head<3>();
  state_.time_offset_s = std::clamp(state_.time_offset_s + delta(3), -options_.max_time_offset_s,
                                    options_.max_time_offset_s);
  state_.rotation_correction =
      (SO3d::exp(delta.tail<3>()) * SO3d::exp(state_.rotation_correction)).log();
}

std::optional<GyroAlignment> Fit::run(double time_offset_s) {
  state_.time_offset_s = time_offset_s;
  for (int i = 0; i < options_.max_iterations && !state_.converged; ++i) {
    const std::vector<Residual> all = residuals();
    if (static_cast<int>(all.size()) < options_.min_motions) return std::nullopt;
    Vector7d slope;
    const Matrix7d H = information(all, scale_of(all), false, &slope);
    const Vector7d delta = -H.ldlt().solve(slope);
    if (!delta.allFinite()) return std::nullopt;
    step(delta);
    state_.iterations = i + 1;
    state_.converged = delta.dot(H * delta) < kStepTolerance;
  }
  const std::vector<Residual> all = residuals();
  if (static_cast<int>(all.size()) < options_.min_motions) return std::nullopt;
  report(all, scale_of(all));
  return state_;
}

void Fit::report(const std::vector<Residual>& residuals, double scale) {
  Vector7d slope;
  state_.covariance = information(residuals, scale, true, &slope).inverse();
  const auto forget = [&](int index) {
    state_.covariance.row(index).setZero();
    state_.covariance.col(index).setZero();
  };
  if (!options_.estimate_time_offset) forget(3);
  for (int i = 4; i < 7 && !options_.estimate_rotation; ++i) forget(i);
  double squares = 0.0;
  for (const Residual& r : residuals) {
    if (r.white.norm() > kInlierWidth * std::sqrt(3.0) * scale) continue;
    ++state_.inliers;
    squares += r.raw.squaredNorm();
  }
  state_.motions = static_cast<int>(residuals.size());
  state_.residual_scale = scale;
  state_.residual_rms_rad = std::sqrt(squares / std::max(1, state_.inliers));
}

}  // namespace

void GyroAlignmentOptions::describe(Config& config) {
  config.field("estimate_time_offset", estimate_time_offset, "estimate the camera-IMU time offset");
  config.field("estimate_rotation", estimate_rotation, "also correct the camera's mounting");
  config.field("max_time_offset_s", max_time_offset_s, "largest time offset looked for [s]");
  config.field("search_step_s", search_step_s, "step of the search for the time offset [s]");
  config.field("vision_rotation_floor", vision_rotation_floor,
               "least standard deviation of a rotation from vision [rad]");
  config.field("time_offset_prior_s", time_offset_prior_s,
               "standard deviation of the time offset before anything is seen [s]");
  config.field("observed_offset_std_s", observed_offset_std_s,
               "a time offset less certain than this is not used [s]");
  config.field("rotation_prior", rotation_prior,
               "standard deviation of the camera's mounting before anything is seen [rad]");
  config.field("robust_width", robust_width, "Huber threshold in standard deviations");
  config.field("min_motions", min_motions, "fewest motions to align with");
  config.field("max_iterations", max_iterations, "most Gauss-Newton iterations");
}

void GyroAlignmentOptions::validate() const {
  const auto positive = [](const char* key, double value) {
    check_option(value > 0.0, std::string("alignment.") + key, value, "> 0");
  };
  check_option(max_time_offset_s > 0.0 && max_time_offset_s <= 1.0, "alignment.max_time_offset_s",
               max_time_offset_s, "> 0 and <= 1");
  check_option(search_step_s >= 1e-4 && search_step_s <= max_time_offset_s,
               "alignment.search_step_s", search_step_s, ">= 0.0001 and <= max_time_offset_s");
  positive("vision_rotation_floor", vision_rotation_floor);
  positive("time_offset_prior_s", time_offset_prior_s);
  positive("observed_offset_std_s", observed_offset_std_s);
  positive("rotation_prior", rotation_prior);
  positive("robust_width", robust_width);
  check_option(min_motions >= 3, "alignment.min_motions", min_motions, ">= 3");
  check_option(max_iterations >= 1, "alignment.max_iterations", max_iterations, ">= 1");
}

std::optional<GyroAlignment> align_gyro(const std::vector<RelativeMotion>& vision,
                                        ImuRange samples,
                                        const ImuNoise& noise,
                                        const GyroAlignmentOptions& options) {
  if (!options.estimate_time_offset) return Fit(vision, samples, noise, options).run(0.0);
  const auto start = search_time_offset(vision, samples, noise, options);
  auto result = Fit(vision, samples, noise, options).run(start.value_or(0.0));
  if (!result) return std::nullopt;
  const double std_s = std::sqrt(result->covariance(3, 3));
  result->time_offset_observed = std_s < options.observed_offset_std_s;
  if (result->time_offset_observed) return result;

  // Too little rotation to tell: no offset is the better guess, and the bias must not suffer.
  GyroAlignmentOptions without_offset = options;
  without_offset.estimate_time_offset = false;
  result = Fit(vision, samples, noise, without_offset).run(0.0);
  if (result) result->covariance(3, 3) = std::pow(options.time_offset_prior_s, 2);
  return result;
}

}  // namespace imslam::imu
