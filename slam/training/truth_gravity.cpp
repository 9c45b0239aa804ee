#include "slam/training/truth_gravity.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "imu_net/preintegration.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/time.hpp"
#include "slam/training/true_time.hpp"

namespace imslam::training {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

constexpr int kRounds = 4;
constexpr double kHeld = 1e12;  ///< information that pins what is not sought

struct Triple {
  std::size_t at[3];
};

/// Rotation of the first interval and bend of the path, by bias and gravity.
struct Bend {
  Vector6 residual;
  Eigen::Matrix<double, 6, 9> J;
  Matrix6 covariance;
};

/// Normal equations of one chunk in [gyro accel gravity].
struct Chunk {
  std::int64_t time_ns = 0;
  std::vector<Triple> triples;
  ImuBias bias;
  Matrix9 H = Matrix9::Zero();
  Vector9 slope = Vector9::Zero();
};

class GravityFitter {
 public:
  GravityFitter(imu::ImuRange samples,
                const ImuNoise& noise,
                const Trajectory& truth,
                const GravityFitOptions& options)
      : samples_(samples), noise_(noise), truth_(truth), options_(options) {
    noise_.gyro_noise_density *= options.gyro_noise_factor;
    noise_.accel_noise_density *= options.accel_noise_factor;
  }

  GravityFit fit();

 private:
  std::vector<Chunk> chunks() const;
  Bend bend(const Triple& triple, const ImuBias& bias) const;
  void linearize(Chunk& chunk) const;
  void step(std::vector<Chunk>& chunks);

  imu::ImuRange samples_;
  ImuNoise noise_;
  const Trajectory& truth_;
  const GravityFitOptions& options_;
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
};

std::vector<Chunk> GravityFitter::chunks() const {
  std::vector<Chunk> result;
  const auto& times_ns = truth_.times_ns;
  const std::int64_t step_ns = to_nanoseconds(options_.interval_s);
  for (std::size_t i = 0; i < times_ns.size();) {
    const auto middle = index_near(times_ns, times_ns[i] + step_ns, step_ns / 10);
    const auto last = index_near(times_ns, times_ns[i] + 2 * step_ns, step_ns / 10);
    if (!middle || !last) {
      ++i;
      continue;
    }
    if (result.empty() || times_ns[i] - result.back().time_ns >= to_nanoseconds(options_.chunk_s)) {
      result.push_back({});
      result.back().time_ns = times_ns[i];
    }
    result.back().triples.push_back({{i, *middle, *last}});
    i = *middle;
  }
  return result;
}

Bend GravityFitter::bend(const Triple& triple, const ImuBias& bias) const {
  const auto pose = [&](int k) -> const lie::SE3d& { return truth_.poses[triple.at[k]]; };
  const auto time = [&](int k) { return truth_.times_ns[triple.at[k]]; };
  const ImuMotion m1 = imu::preintegrate(samples_, time(0), time(1), bias, noise_);
  const ImuMotion m2 = imu::preintegrate(samples_, time(1), time(2), bias, noise_);
  const double T1 = m1.dt_s;
  const double T2 = m2.dt_s;
  const Eigen::Matrix3d R0 = pose(0).rotation().matrix();
  const Eigen::Matrix3d R1 = pose(1).rotation().matrix();
  const double gravity_weight = T2 * (T1 + T2) / 2.0;
  Bend result;
  result.residual.head<3>() =
      (m1.dR.inverse() * pose(0).rotation().inverse() * pose(1).rotation()).log();
  result.residual.tail<3>() = pose(2).translation() - pose(1).translation() -
                              T2 / T1 * (pose(1).translation() - pose(0).translation()) -
                              gravity_weight * gravity_ - T2 * (R0 * (m1.dv - m1.dp / T1)) -
                              R1 * m2.dp;
  result.J << -m1.J_dR_bias, Eigen::Matrix3d::Zero(),
      -T2 * R0 * (m1.J_dv_bias - m1.J_dp_bias / T1) - R1 * m2.J_dp_bias,
      -gravity_weight * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 6, 9> G1 = Eigen::Matrix<double, 6, 9>::Zero();
  G1.topLeftCorner<3, 3>().setIdentity();
  G1.block<3, 3>(3, 3) = T2 * R0;
  G1.block<3, 3>(3, 6) = -T2 / T1 * R0;
  result.covariance = G1 * m1.covariance * G1.transpose();
  result.covariance.bottomRightCorner<3, 3>() +=
      R1 * m2.covariance.bottomRightCorner<3, 3>() * R1.transpose();
  return result;
}

void GravityFitter::linearize(Chunk& chunk) const {
  chunk.H.setZero();
  chunk.slope.setZero();
  const double gyro_weight = 1.0 / (noise_.gyro_bias_sigma * noise_.gyro_bias_sigma);
  const double accel_weight = 1.0 / (noise_.accel_bias_sigma * noise_.accel_bias_sigma);
  chunk.H.diagonal().head<6>() << Eigen::Vector3d::Constant(gyro_weight),
      Eigen::Vector3d::Constant(accel_weight);
  chunk.slope.head<6>() << gyro_weight * chunk.bias.gyro, accel_weight * chunk.bias.accel;
  for (const Triple& triple : chunk.triples) {
    const Bend b = bend(triple, chunk.bias);
    const Matrix6 W = b.covariance.ldlt().solve(Matrix6::Identity());
    chunk.H += b.J.transpose() * W * b.J;
    chunk.slope += b.J.transpose() * W * b.residual;
  }
}

/// Biases are eliminated chunk by chunk: they meet in gravity only.
void GravityFitter::step(std::vector<Chunk>& chunks) {
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  const double sigma = options_.direction_sigma * options_.magnitude;
  const Eigen::Vector3d along = gravity_.normalized();
  Eigen::Matrix3d S = Eigen::Matrix3d::Identity() / (sigma * sigma);
  Eigen::Vector3d r = (gravity_ - options_.magnitude * down) / (sigma * sigma);
  for (const Chunk& c : chunks) {
    const Eigen::Matrix<double, 3, 6> K =
        c.H.topLeftCorner<6, 6>().ldlt().solve(c.H.topRightCorner<6, 3>()).transpose();
    S += c.H.bottomRightCorner<3, 3>() - K * c.H.topRightCorner<6, 3>();
    r += c.slope.tail<3>() - K * c.slope.head<6>();
  }
  information_ = S;
  const Eigen::Vector3d change =
      -(S + kHeld * along * along.transpose()).ldlt().solve(r - along * along.dot(r));
  for (Chunk& c : chunks) {
    const Vector6 rest = c.slope.head<6>() + c.H.topRightCorner<6, 3>() * change;
    const Vector6 d = -c.H.topLeftCorner<6, 6>().ldlt().solve(rest);
    c.bias.gyro += d.head<3>();
    c.bias.accel += d.tail<3>();
  }
  gravity_ = options_.magnitude * (gravity_ + change).normalized();
}

GravityFit GravityFitter::fit() {
  gravity_ = Eigen::Vector3d(0.0, 0.0, -options_.magnitude);
  std::vector<Chunk> all = chunks();
  for (int round = 0; round < kRounds && !all.empty(); ++round) {
    parallel_for(all.size(), [&](std::size_t i) { linearize(all[i]); });
    step(all);
  }
  GravityFit result;
  result.gravity_world = gravity_;
  const Eigen::Vector3d direction = gravity_.normalized();
  result.tilt = std::atan2(direction.head<2>().norm(), -direction.z());
  result.tilt_sigma = options_.direction_sigma;
  if (!all.empty()) {
    const Eigen::Matrix3d held = information_ + kHeld * direction * direction.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(held);
    result.tilt_sigma = 1.0 / (std::sqrt(eigen.eigenvalues()[0]) * options_.magnitude);
  }
  for (const Chunk& chunk : all) result.biases.push_back({chunk.time_ns, chunk.bias});
  return result;
}

}  // namespace

const StampedBias* bias_at(const std::vector<StampedBias>& biases, std::int64_t time_ns) {
  if (biases.empty()) return nullptr;
  const auto later =
      std::upper_bound(biases.begin(), biases.end(), time_ns,
                       [](std::int64_t t, const StampedBias& b) { return t < b.time_ns; });
  return later == biases.begin() ? &biases.front() : &*std::prev(later);
}

GravityFit fit_gravity(imu::ImuRange samples,
                       const ImuNoise& noise,
                       const Trajectory& truth,
                       const GravityFitOptions& options) {
  return GravityFitter(samples, noise, truth, options).fit();
}

}  // namespace imslam::training
