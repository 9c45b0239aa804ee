#include "slam/training/truth_gravity.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"
#include "slam/base/time.hpp"
#include "slam/training/true_time.hpp"
#include "slam/training/truth_bend.hpp"

namespace imslam::training {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

constexpr int kRounds = 4;
constexpr double kHeld = 1e12;  ///< information that pins what is not sought

/// Normal equations of one chunk in [gyro accel gravity].
struct Chunk {
  std::int64_t time_ns = 0;
  std::vector<PoseTriple> triples;
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
    result.back().triples.push_back({i, *middle, *last});
    i = *middle;
  }
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
  for (const PoseTriple& triple : chunk.triples) {
    const Bend b = bend(samples_, noise_, truth_, triple, chunk.bias, gravity_);
    if (!b.usable) continue;
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
