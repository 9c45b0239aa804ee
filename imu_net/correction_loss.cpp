#include "imu_net/correction_loss.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "imu_net/imu_corrector.hpp"
#include "imu_net/preintegration_gradient.hpp"

namespace imslam::imu {
namespace {

using nn::Index;
using nn::Var;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Matrix96d = Eigen::Matrix<double, 9, 6>;

constexpr double kRobust = 16.0;  // [1] of e^T P^-1 e / 9

/// Gradients with respect to the answer, [3, T, 2] each.
struct AnswerGradient {
  double* offset;
  double* noise;
  double* edge_noise;
  double* log_sigma;
};

Matrix96d bias_jacobian(const ImuMotion& motion) {
  Matrix96d J;
  J << motion.J_dR_bias, motion.J_dv_bias, motion.J_dp_bias;
  return J;
}

/// Losses of the windows of one log, and their gradients.
template <typename S>
class LossOfLog {
 public:
  LossOfLog(const nn::Tape<S>& tape, const ImuAnswer& answer, const CorrectionTask& task)
      : tape_(tape),
        answer_(answer),
        task_(task),
        bins_(static_cast<Index>(task.frame_times.size())) {
    nn::expects_shape(tape.shape(answer.offset) == nn::Shape{3, bins_, 2},
                      "correction_loss: an answer for each frame", tape.shape(answer.offset));
    correct();
  }

  /// Mean loss; adds its gradient.
  double run(AnswerGradient out) {
    double sum = 0.0;
    int count = 0;
    for (const ImuMotion& window : task_.windows) count += add_window(window, out, sum) ? 1 : 0;
    if (count == 0) return 0.0;
    for (double* const part : {out.offset, out.noise, out.edge_noise, out.log_sigma}) {
      for (Index i = 0; i < 6 * bins_; ++i) part[i] /= count;
    }
    return sum / count;
  }

 private:
  Index place(int axis, Index bin, int sensor) const { return 2 * (axis * bins_ + bin) + sensor; }
  double number(Var v, Index i) const { return static_cast<double>(tape_.data(v)[i]); }

  /// The newest frame at or before a time, -1 if there is none.
  Index bin_at(std::int64_t time_ns) const {
    const auto& times = task_.frame_times;
    return std::upper_bound(times.begin(), times.end(), time_ns) - times.begin() - 1;
  }

  ImuCorrection correction_of(Index bin) const {
    ImuCorrection said;
    for (int axis = 0; axis < 3; ++axis) {
      const Index gyro = place(axis, bin, 0);
      const Index accel = place(axis, bin, 1);
      const double gyro_density = task_.noise.gyro_noise_density;
      const double accel_density = task_.noise.accel_noise_density;
      said.offset.gyro[axis] = number(answer_.offset, gyro);
      said.offset.accel[axis] = number(answer_.offset, accel);
      said.noise.gyro[axis] = added_variance(gyro_density, number(answer_.noise, gyro));
      said.noise.accel[axis] = added_variance(accel_density, number(answer_.noise, accel));
      said.edge_noise.gyro[axis] = added_variance(gyro_density, number(answer_.edge_noise, gyro));
      said.edge_noise.accel[axis] =
          added_variance(accel_density, number(answer_.edge_noise, accel));
      said.sigma.gyro[axis] = std::exp(number(answer_.log_sigma, gyro));
      said.sigma.accel[axis] = std::exp(number(answer_.log_sigma, accel));
    }
    return said;
  }

  void correct() {
    corrections_.reserve(static_cast<std::size_t>(bins_));
    for (Index bin = 0; bin < bins_; ++bin) corrections_.push_back(correction_of(bin));
    samples_.reserve(task_.samples->size());
    Index bin = -1;
    for (const ImuSample& sample : *task_.samples) {
      while (bin + 1 < bins_ &&
             task_.frame_times[static_cast<std::size_t>(bin + 1)] <= sample.time_ns) {
        ++bin;
      }
      bin_of_sample_.push_back(bin);
      samples_.push_back(sample);
      edge_samples_.push_back(sample);
      if (bin < 0) continue;
      ImuCorrection said = corrections_[static_cast<std::size_t>(bin)];
      samples_.back() = corrected(sample, said, task_.noise);
      said.noise = said.edge_noise;
      edge_samples_.back() = corrected(sample, said, task_.noise);
    }
  }

  bool add_window(const ImuMotion& truth, AnswerGradient out, double& sum) {
    const Index bin = bin_at(truth.time0_ns);
    if (bin < 0) return false;
    const bool edge = truth.dt_s <= ImuNetwork<S>::kLongestEdge_s;
    const std::vector<ImuSample>& samples = edge ? edge_samples_ : samples_;
    const ImuRange around = ImuRange(samples).around(truth.time0_ns, truth.time1_ns);
    const ImuMotion motion = preintegrate(around, truth.time0_ns, truth.time1_ns, ImuBias(),
                                          task_.noise, 0.0, {}, &record_);
    if (!motion.valid || motion.degraded) return false;

    const ImuBias& sigma = corrections_[static_cast<std::size_t>(bin)].sigma;
    Eigen::Matrix<double, 6, 1> variance;
    variance << sigma.gyro.cwiseAbs2(), sigma.accel.cwiseAbs2();
    const Matrix96d J = bias_jacobian(motion);
    const Matrix9d P =
        motion.covariance + J * variance.asDiagonal() * J.transpose() + truth.covariance;
    const Vector9d error = difference(motion, truth);
    const Eigen::LLT<Matrix9d> llt(P);
    if (llt.info() != Eigen::Success) return false;
    const Vector9d whitened = llt.solve(error);
    const double square = error.dot(whitened) / 9.0;
    const bool far = square > kRobust;
    const double weight = far ? std::sqrt(kRobust / square) : 1.0;
    const double log_det = 2.0 * Matrix9d(llt.matrixL()).diagonal().array().log().sum();
    sum += 0.5 * (robust_square(square) + log_det / 9.0);

    MotionGradient dL;
    dL.motion = weight / 9.0 * whitened;
    dL.motion.head<3>() =
        lie::SO3d::right_jacobian_inverse(error.head<3>()).transpose() * dL.motion.head<3>();
    dL.covariance =
        0.5 / 9.0 * (llt.solve(Matrix9d::Identity()) - weight * whitened * whitened.transpose());
    const Eigen::Matrix<double, 6, 1> d_variance = (J.transpose() * dL.covariance * J).diagonal();
    for (int axis = 0; axis < 3; ++axis) {
      out.log_sigma[place(axis, bin, 0)] += 2.0 * variance[axis] * d_variance[axis];
      out.log_sigma[place(axis, bin, 1)] += 2.0 * variance[3 + axis] * d_variance[3 + axis];
    }
    send_back(around, static_cast<std::size_t>(around.begin() - samples.data()), edge, dL, out);
    return true;
  }

  /// From the integrated motion to the answers that went into it; `first`: index of its first
  /// sample.
  void send_back(
      ImuRange around, std::size_t first, bool edge, const MotionGradient& dL, AnswerGradient out) {
    gradients_.assign(around.size(), SampleGradient());
    add_preintegration_gradient(record_, dL, gradients_.data());
    double* const noise_out = edge ? out.edge_noise : out.noise;
    for (std::size_t i = 0; i < around.size(); ++i) {
      const Index bin = bin_of_sample_[first + i];
      if (bin < 0) continue;
      const ImuCorrection& said = corrections_[static_cast<std::size_t>(bin)];
      const ImuNoiseVariance& noise = edge ? said.edge_noise : said.noise;
      const SampleGradient& g = gradients_[i];
      for (int axis = 0; axis < 3; ++axis) {
        const Index gyro = place(axis, bin, 0);
        const Index accel = place(axis, bin, 1);
        out.offset[gyro] -= g.angular_velocity[axis];
        out.offset[accel] -= g.linear_acceleration[axis];
        noise_out[gyro] += 2.0 * noise.gyro[axis] * g.gyro_variance[axis];
        noise_out[accel] += 2.0 * noise.accel[axis] * g.accel_variance[axis];
      }
    }
  }

  const nn::Tape<S>& tape_;
  const ImuAnswer& answer_;
  const CorrectionTask& task_;
  Index bins_;
  std::vector<ImuCorrection> corrections_;
  std::vector<ImuSample> samples_;       ///< corrected, with the noise over seconds
  std::vector<ImuSample> edge_samples_;  ///< corrected, with that of short edges
  std::vector<Index> bin_of_sample_;
  PreintegrationRecord record_;  ///< of the present window
  std::vector<SampleGradient> gradients_;
};

}  // namespace

double robust_square(double x) { return x > kRobust ? 2.0 * std::sqrt(kRobust * x) - kRobust : x; }

template <typename S>
Var correction_loss(nn::Tape<S>& tape, const ImuAnswer& answer, const CorrectionTask& task) {
  const Index count = 6 * static_cast<Index>(task.frame_times.size());
  const auto zeros = [&] {
    double* const numbers = tape.template keep<double>(count);
    std::fill_n(numbers, count, 0.0);
    return numbers;
  };
  const AnswerGradient gradient{zeros(), zeros(), zeros(), zeros()};
  const Var y = tape.make({});
  tape.data(y)[0] = static_cast<S>(LossOfLog<S>(tape, answer, task).run(gradient));
  const ImuAnswer inputs = answer;
  return tape.record(y, {answer.offset, answer.noise, answer.edge_noise, answer.log_sigma},
                     [=](nn::Tape<S>& t) {
                       const double dy = static_cast<double>(t.gradient_data(y)[0]);
                       const auto send = [&](Var v, const double* numbers) {
                         if (!t.wants_gradient(v)) return;
                         S* const to = t.gradient_data(v);
                         for (Index i = 0; i < count; ++i) to[i] += static_cast<S>(dy * numbers[i]);
                       };
                       send(inputs.offset, gradient.offset);
                       send(inputs.noise, gradient.noise);
                       send(inputs.edge_noise, gradient.edge_noise);
                       send(inputs.log_sigma, gradient.log_sigma);
                     });
}

template Var correction_loss(nn::Tape<float>&, const ImuAnswer&, const CorrectionTask&);
template Var correction_loss(nn::Tape<double>&, const ImuAnswer&, const CorrectionTask&);

}  // namespace imslam::imu
