#include "vo_net/motion_cost.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "vo_net/motion_noise.hpp"
#include "vo_net/network_pixels.hpp"
#include "vo_net/pose_layer_gradient.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;

/// dU/d(every number of one prediction), as long as the numbers themselves.
struct AnswerSlopes {
  double* displacement = nullptr;
  double* log_sigma = nullptr;
  double* correlation = nullptr;
  double* confidence = nullptr;
};

template <typename S>
double* zeros(nn::Tape<S>& tape, Index count) {
  double* const numbers = tape.template keep<double>(count);
  std::fill_n(numbers, count, 0.0);
  return numbers;
}

template <typename S>
AnswerSlopes zero_slopes(nn::Tape<S>& tape, const MatchPrediction& said) {
  const auto like = [&](Var v) { return v ? zeros(tape, tape.shape(v).size()) : nullptr; };
  return {like(said.displacement), like(said.log_sigma), like(said.correlation),
          like(said.confidence)};
}

/// One answer's numbers and where their slopes go.
template <typename S>
class AnswerPullBack {
 public:
  AnswerPullBack(const nn::Tape<S>& tape,
                 const MatchPrediction& said,
                 int shrink,
                 AnswerSlopes slopes)
      : tape_(tape), said_(said), shrink_(shrink), slopes_(slopes) {}

  /// From left1 = left0 + displacement and Omega = (C + floor^2 I)^-1,
  /// C = 3 [sx^2, r sx sy; r sx sy, sy^2]: dC = -Omega dOmega Omega.
  void flow(Index i, const Correspondence& c, const CorrespondenceGradient& g) const {
    for (Index d = 0; d < 2; ++d) slopes_.displacement[2 * i + d] += shrink_ * g.left1[d];
    const Eigen::Matrix2d dC = -c.flow_information * g.flow_information * c.flow_information;
    const double sx = scale(2 * i);
    const double sy = scale(2 * i + 1);
    const double r = static_cast<double>(tape_.data(said_.correlation)[i]);
    const double across = kVarianceOfScale * sx * sy * (dC(0, 1) + dC(1, 0));
    slopes_.log_sigma[2 * i] += 2.0 * kVarianceOfScale * sx * sx * dC(0, 0) + r * across;
    slopes_.log_sigma[2 * i + 1] += 2.0 * kVarianceOfScale * sy * sy * dC(1, 1) + r * across;
    slopes_.correlation[i] += across;
  }

  void stereo(Index i, double information, double by_disparity, double by_information) const {
    slopes_.displacement[i] -= shrink_ * by_disparity;
    const double s = scale(i);
    slopes_.log_sigma[i] -=
        information * information * by_information * 2.0 * kVarianceOfScale * s * s;
  }

  double confidence(Index i) const {
    return 1.0 / (1.0 + std::exp(-static_cast<double>(tape_.data(said_.confidence)[i])));
  }
  void weight(Index i, double by_weight) const {
    const double w = confidence(i);
    slopes_.confidence[i] += w * (1.0 - w) * by_weight;
  }

 private:
  double scale(Index i) const {
    return shrink_ * std::exp(static_cast<double>(tape_.data(said_.log_sigma)[i]));
  }

  const nn::Tape<S>& tape_;
  const MatchPrediction& said_;
  double shrink_;
  AnswerSlopes slopes_;
};

/// From the correspondences' slopes to those of the three answers.
template <typename S>
void pull_back(const Correspondences& now,
               const std::vector<CorrespondenceGradient>& gradients,
               const AnswerPullBack<S>& flow,
               const AnswerPullBack<S>& stereo0,
               const AnswerPullBack<S>& stereo1) {
  for (std::size_t k = 0; k < now.size(); ++k) {
    const auto i = static_cast<Index>(k);
    const Correspondence& c = now[k];
    const CorrespondenceGradient& g = gradients[k];
    if (c.learned.left1) flow.flow(i, c, g);
    if (c.learned.disparity0) {
      stereo0.stereo(i, c.disparity0_information, g.disparity0, g.disparity0_information);
    }
    if (c.learned.disparity1) {
      stereo1.stereo(i, c.disparity1_information, g.disparity1, g.disparity1_information);
    }
    const std::array<const AnswerPullBack<S>*, 3> all{&stereo0, &flow, &stereo1};
    const auto weakest = std::min_element(all.begin(), all.end(), [&](auto* a, auto* b) {
      return a->confidence(i) < b->confidence(i);
    });
    (*weakest)->weight(i, g.weight);
  }
}

/// dU/da of Sigma = F Sigma_0 F, F = diag(e^a ...): the rows and columns of a count once each.
template <typename S>
double* slopes_by_noise(nn::Tape<S>& tape, const MotionSlope& slope, const RelativeMotion& motion) {
  const Eigen::Matrix<double, 6, 1> rows =
      2.0 * slope.by_covariance.cwiseProduct(motion.covariance).rowwise().sum();
  double* const slopes = zeros(tape, 2);
  slopes[0] = rows.head<3>().sum();
  slopes[1] = rows.tail<3>().sum();
  return slopes;
}

template <typename S>
Eigen::Matrix<double, 6, 1> factors_of(const nn::Tape<S>& tape, Var noise) {
  if (!noise) return Eigen::Matrix<double, 6, 1>::Ones();
  return noise_factors(static_cast<double>(tape.data(noise)[0]),
                       static_cast<double>(tape.data(noise)[1]));
}

RelativeMotion motion_of(const PoseLayerResult& pose,
                         const MotionRecipe& recipe,
                         const Eigen::Matrix<double, 6, 1>& factors) {
  RelativeMotion motion;
  motion.time0_ns = recipe.time0_ns;
  motion.time1_ns = recipe.time1_ns;
  motion.T_body0_body1 = pose.T_body0_body1;
  const double shared = 1.0 + recipe.shared_error * static_cast<double>(pose.inliers);
  motion.covariance = factors.asDiagonal() * (shared * pose.covariance) * factors.asDiagonal();
  motion.J_disparity_offset = pose.J_disparity_offset;
  motion.J_focal_error = pose.J_focal_error;
  motion.disparity_offset = pose.disparity_offset;
  motion.inliers = pose.inliers;
  motion.valid = pose.valid;
  return motion;
}

template <typename S>
void send(nn::Tape<S>& tape, Var v, const double* slopes, double dU) {
  if (!tape.wants_gradient(v)) return;
  S* const to = tape.gradient_data(v);
  const Index count = tape.shape(v).size();
  for (Index i = 0; i < count; ++i) to[i] += static_cast<S>(dU * slopes[i]);
}

template <typename S>
void send(nn::Tape<S>& tape, const MatchPrediction& said, const AnswerSlopes& slopes, double dU) {
  send(tape, said.displacement, slopes.displacement, dU);
  send(tape, said.log_sigma, slopes.log_sigma, dU);
  if (said.correlation) send(tape, said.correlation, slopes.correlation, dU);
  send(tape, said.confidence, slopes.confidence, dU);
}

}  // namespace

template <typename S>
ReplayedMotion<S> motion_cost(nn::Tape<S>& tape,
                              const ReplayedMatch& match,
                              const Correspondences& recorded,
                              const MotionRecipe& recipe,
                              Var noise,
                              const MotionCost& cost) {
  ReplayedMotion<S> result;
  result.cost = tape.make({});
  tape.data(result.cost)[0] = S(0);
  result.correspondences = replayed(tape, match, recorded, recipe.sigma_floor);
  result.pose = solve_pose(result.correspondences, recipe.camera, recipe.pose, recipe.start,
                           recipe.disparity_offset);
  if (!result.pose.valid) return result;
  const RelativeMotion motion = motion_of(result.pose, recipe, factors_of(tape, noise));
  const MotionSlope slope = cost(motion);
  const auto gradient = pose_layer_gradient(result.correspondences, recipe.camera, recipe.pose,
                                            result.pose, slope.by_motion);
  if (!gradient || !std::isfinite(slope.cost)) return result;
  result.usable = true;
  tape.data(result.cost)[0] = static_cast<S>(slope.cost);

  const std::array<MatchPrediction, 3> said{match.flow.prediction, match.stereo0.prediction,
                                            match.stereo1.prediction};
  const std::array<AnswerSlopes, 3> slopes{zero_slopes(tape, said[0]), zero_slopes(tape, said[1]),
                                           zero_slopes(tape, said[2])};
  pull_back(result.correspondences, gradient->correspondences,
            AnswerPullBack<S>(tape, said[0], match.shrink, slopes[0]),
            AnswerPullBack<S>(tape, said[1], match.shrink, slopes[1]),
            AnswerPullBack<S>(tape, said[2], match.shrink, slopes[2]));
  double* const by_noise = slopes_by_noise(tape, slope, motion);
  const Var y = result.cost;
  tape.record(y,
              {said[0].displacement, said[0].confidence, said[1].displacement, said[1].confidence,
               said[2].displacement, said[2].confidence, noise},
              [=](nn::Tape<S>& back) {
                const double dU = static_cast<double>(back.gradient_data(y)[0]);
                for (std::size_t i = 0; i < 3; ++i) send(back, said[i], slopes[i], dU);
                if (noise) send(back, noise, by_noise, dU);
              });
  return result;
}

template <typename S>
Var noise_cost(nn::Tape<S>& tape, const RelativeMotion& motion, Var noise, const MotionCost& cost) {
  RelativeMotion now = motion;
  const Eigen::Matrix<double, 6, 1> factors = factors_of(tape, noise);
  now.covariance = factors.asDiagonal() * motion.covariance * factors.asDiagonal();
  const MotionSlope slope = cost(now);
  const Var y = tape.make({});
  tape.data(y)[0] = static_cast<S>(slope.cost);
  double* const by_noise = slopes_by_noise(tape, slope, now);
  return tape.record(y, {noise}, [=](nn::Tape<S>& back) {
    send(back, noise, by_noise, static_cast<double>(back.gradient_data(y)[0]));
  });
}

#define INSTANTIATE(S)                                                                     \
  template ReplayedMotion<S> motion_cost(nn::Tape<S>&, const ReplayedMatch&,               \
                                         const Correspondences&, const MotionRecipe&, Var, \
                                         const MotionCost&);                               \
  template Var noise_cost(nn::Tape<S>&, const RelativeMotion&, Var, const MotionCost&);
INSTANTIATE(float)
INSTANTIATE(double)

}  // namespace imslam::vo
