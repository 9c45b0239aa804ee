#include "imu_net/bias_observers.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "imu_net/gravity_alignment.hpp"

namespace imslam::imu {
namespace {

constexpr double kGravity = 9.81;         // [m/s^2]
constexpr double kGyroBiasFactor = 2.0;   // on what the sensor's kind allows, before anything
constexpr double kAccelBiasFactor = 1.5;  // was seen
constexpr double kGyroWarmUp = 3e-5;      // [rad/s/sqrt(s)] beside the datasheet's walk
constexpr double kAccelWarmUp = 3e-4;     // [m/s^2/sqrt(s)]
constexpr double kSway = 2e-4;            // [rad/s] of a body that counts as still
constexpr double kGravityUnknown = 0.02;  // [m/s^2] gravity differs from place to place
constexpr std::size_t kRestBins = 10;

double squared(double x) { return x * x; }

}  // namespace

RestObserver::RestObserver(const ImuNoise& noise)
    : noise_(noise),
      gyro_variance_(Eigen::Vector3d::Constant(squared(kGyroBiasFactor * noise.gyro_bias_sigma))),
      accel_covariance_(squared(kAccelBiasFactor * noise.accel_bias_sigma) *
                        Eigen::Matrix3d::Identity()) {}

void RestObserver::add(const ImuBin& bin, double dt_s) {
  gyro_variance_.array() += dt_s * (squared(noise_.gyro_random_walk) + squared(kGyroWarmUp));
  accel_covariance_.diagonal().array() +=
      dt_s * (squared(noise_.accel_random_walk) + squared(kAccelWarmUp));
  since_rest_s_ += dt_s;
  reading_.reset();
  if (bin.count == 0) return recent_.clear();
  BinMean mean;
  mean << bin.rate, bin.force;
  recent_.push_back(mean);
  if (recent_.size() > kRestBins) recent_.pop_front();
  if (recent_.size() < kRestBins) return;
  StaticDetectorOptions options;
  options.bin_s = ImuBin::kLength_s;
  const Stillness rest = assess_bins({recent_.begin(), recent_.end()}, kRestBins, noise_, options);
  if (!rest.still) return;
  since_rest_s_ = 0.0;
  learn(recent_[kRestBins / 2], rest);
}

void RestObserver::learn(const BinMean& bin, const Stillness& rest) {
  const double gyro_noise = squared(noise_.gyro_noise_density) / ImuBin::kLength_s;
  const double accel_noise = squared(noise_.accel_noise_density) / ImuBin::kLength_s;
  RestReading reading;
  reading.rate = bin.head<3>();
  for (int i = 0; i < 3; ++i) {
    const double R = std::max(squared(rest.rate_spread[i]), gyro_noise) + squared(kSway);
    const double gain = gyro_variance_[i] / (gyro_variance_[i] + R);
    gyro_[i] += gain * (bin[i] - gyro_[i]);
    gyro_variance_[i] *= 1.0 - gain;
    reading.variance[i] = R;
  }
  reading_ = reading;
  const Eigen::Vector3d force = bin.tail<3>() - accel_;
  const Eigen::Vector3d up = force.normalized();
  // The unknown gravity is the same in every bin: it must not average out within a second.
  const double R = rest.force_spread.squaredNorm() + accel_noise + squared(kGravityUnknown) * 10.0;
  const Eigen::Vector3d cross = accel_covariance_ * up;
  const Eigen::Vector3d gain = cross / (up.dot(cross) + R);
  accel_ += gain * (force.norm() - kGravity);
  accel_covariance_ -= gain * cross.transpose();
  accel_covariance_ = 0.5 * (accel_covariance_ + accel_covariance_.transpose()).eval();
}

namespace {

constexpr double kFirstTilt = 0.3;     // [rad]
constexpr double kShapeError = 0.005;  // [1] scale and misalignment of the gyro
constexpr double kForceFactor = 2.0;   // acceleration for each unit of | |force| - g |
constexpr double kLeastForce = 0.3;    // [g] below it the direction says nothing

}  // namespace

GravityObserver::GravityObserver(const ImuNoise& noise, const Accelerations& accelerations)
    : noise_(noise), accelerations_(accelerations), P_(Eigen::Matrix<double, 6, 6>::Zero()) {
  P_.diagonal() << Eigen::Vector3d::Constant(squared(kFirstTilt)),
      Eigen::Vector3d::Constant(squared(kGyroBiasFactor * noise.gyro_bias_sigma));
}

void GravityObserver::add(const ImuBin& bin,
                          double dt_s,
                          const std::optional<RestReading>& rest_reading) {
  const bool upright = bin.count > 0 && bin.force.norm() > kLeastForce * kGravity;
  if (!begun_) {
    if (!upright) return;
    R_level_body_ = upright_rotation(bin.force);
    begun_ = true;
    return;
  }
  if (bin.count == 0) {  // turned by nobody knows how much
    P_.diagonal().head<3>().array() += dt_s * squared(kFirstTilt);
    return;
  }
  predict(bin.rate, dt_s);
  if (upright) correct(bin.force);
  if (rest_reading) rest(*rest_reading);
}

void GravityObserver::predict(const Eigen::Vector3d& rate, double dt_s) {
  const Eigen::Vector3d angle = (rate - bias_) * dt_s;
  const lie::SO3d step = lie::SO3d::exp(angle);
  R_level_body_ = R_level_body_ * step;
  Eigen::Matrix<double, 6, 6> F = Eigen::Matrix<double, 6, 6>::Identity();
  F.topLeftCorner<3, 3>() = step.inverse().matrix();
  F.topRightCorner<3, 3>() = -dt_s * Eigen::Matrix3d::Identity();
  P_ = (F * P_ * F.transpose()).eval();
  P_.diagonal().head<3>().array() +=
      dt_s * squared(noise_.gyro_noise_density) + squared(kShapeError * angle.norm());
  P_.diagonal().tail<3>().array() +=
      dt_s * (squared(noise_.gyro_random_walk) + squared(kGyroWarmUp));
}

void GravityObserver::correct(const Eigen::Vector3d& force) {
  const Eigen::Vector3d up = R_level_body_.inverse() * Eigen::Vector3d::UnitZ();
  const double noise =
      accelerations_.least + kForceFactor * std::abs(force.norm() - kGravity);  // [m/s^2]
  Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
  H.leftCols<3>() = lie::skew(up);
  update(H, force.normalized() - up,
         Eigen::Vector3d::Constant(accelerations_.correlation * squared(noise / kGravity)));
}

void GravityObserver::rest(const RestReading& reading) {
  Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
  H.rightCols<3>().setIdentity();
  update(H, reading.rate - bias_, reading.variance);
}

void GravityObserver::update(const Eigen::Matrix<double, 3, 6>& H,
                             const Eigen::Vector3d& residual,
                             const Eigen::Vector3d& variance) {
  Eigen::Matrix3d S = H * P_ * H.transpose();
  S.diagonal() += variance;
  const Eigen::Matrix<double, 6, 3> cross = P_ * H.transpose();
  const Eigen::Matrix<double, 6, 3> gain = S.ldlt().solve(cross.transpose()).transpose();
  const Eigen::Matrix<double, 6, 1> change = gain * residual;
  R_level_body_ = R_level_body_ * lie::SO3d::exp(change.head<3>());
  bias_ += change.tail<3>();
  P_ -= gain * cross.transpose();
  P_ = 0.5 * (P_ + P_.transpose()).eval();
}

namespace {

constexpr double kMemory = 1200.0;         // [bins]
constexpr double kTurnCorrelation = 60.0;  // [bins] twice the time for which a turn lasts
constexpr double kLeastTurning = 0.01;     // [rad/s] a slow turn looks like a bias
constexpr double kLeastMeanSigma = 1e-3;   // [rad/s]

}  // namespace

void MeanObserver::add(const ImuBin& bin) {
  if (bin.count == 0) return;
  count_ = std::min(count_ + 1.0, kMemory);
  const Eigen::Vector3d change = bin.rate - mean_;
  mean_ += change / count_;
  variance_ += (change.cwiseAbs2() * (1.0 - 1.0 / count_) - variance_) / count_;
}

BiasBelief MeanObserver::gyro() const {
  const double independent = std::max(1.0, count_ / kTurnCorrelation);
  const Eigen::Array3d turning = variance_.array() + squared(kLeastTurning);
  return {mean_, (turning / independent + squared(kLeastMeanSigma)).sqrt()};
}

}  // namespace imslam::imu
