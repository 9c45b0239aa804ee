#include "vo_net/motion_noise.hpp"

#include <algorithm>
#include <cmath>

#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/shipped_file.hpp"

namespace imslam::vo {
namespace {

using nn::Var;

constexpr int kHidden = 16;
/// Of log factors: half or double. How well others foretell one motion shows nothing of the errors
/// that neighbours share, so that it asks for a sigma far below what their sum deserves.
constexpr double kLargest = 0.693;

// Units that make features of ordinary motions about 1.
constexpr double kSigma = 1e-3;       // [m], [rad]
constexpr double kPoints = 300.0;     // inliers of a good frame
constexpr double kDisparity_px = 16;  // of a scene at ordinary distance

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

float log_ratio(double value, double unit) {
  return static_cast<float>(std::log(std::max(value, 1e-6 * unit) / unit));
}

}  // namespace

MotionNoiseFeatures motion_noise_features(const PoseLayerResult& pose,
                                          const Correspondences& correspondences,
                                          const StereoCamera& camera) {
  std::vector<double> disparities;
  std::vector<double> flows;
  double learned = 0.0;
  double weight = 0.0;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    if (pose.is_inlier[i] == 0) continue;
    const Correspondence& c = correspondences[i];
    disparities.push_back(c.disparity0);
    flows.push_back((c.left1 - c.left0).norm());
    learned += c.learned.left1 ? 1.0 : 0.0;
    weight += c.weight;
  }
  const double inliers = std::max(1.0, static_cast<double>(disparities.size()));
  const double tracked = std::max(1.0, static_cast<double>(correspondences.size()));
  const auto sigma = [&](int first) {
    return std::sqrt(std::max(0.0, pose.covariance.diagonal().segment<3>(first).mean()));
  };
  MotionNoiseFeatures features;
  features.values = {log_ratio(pose.noise_scale, 1.0),
                     static_cast<float>(inliers / tracked),
                     log_ratio(inliers, kPoints),
                     static_cast<float>(learned / inliers),
                     static_cast<float>(weight / inliers),
                     0.3F * log_ratio(sigma(0), kSigma),
                     0.3F * log_ratio(sigma(3), 0.1 * kSigma),
                     log_ratio(median(std::move(disparities)), kDisparity_px),
                     log_ratio(1.0 + median(std::move(flows)), 0.01 * camera.width)};
  return features;
}

template <typename S>
MotionNoise<S>::MotionNoise(Random& random)
    : hidden(MotionNoiseFeatures::kCount, kHidden, random), output(kHidden, 2, random) {
  initialise_constant(output.weight, 0.0);
}

template <typename S>
Var MotionNoise<S>::forward(nn::Tape<S>& tape, Var features) const {
  const Var inner = tanh(tape, hidden.forward(tape, features));
  const Var said = output.forward(tape, inner);
  return scale(tape, tanh(tape, scale(tape, said, 1.0 / kLargest)), kLargest);
}

template <typename S>
void MotionNoise<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  hidden.collect(list, prefix + "hidden.");
  output.collect(list, prefix + "output.");
}

template struct MotionNoise<float>;
template struct MotionNoise<double>;

Eigen::Matrix<double, 6, 1> noise_factors(double translation, double rotation) {
  Eigen::Matrix<double, 6, 1> factors;
  factors << Eigen::Vector3d::Constant(std::exp(translation)),
      Eigen::Vector3d::Constant(std::exp(rotation));
  return factors;
}

Eigen::Matrix<double, 6, 1> noise_factors(const MotionNoise<float>& network,
                                          const MotionNoiseFeatures& features) {
  nn::Tape<float> tape(nn::Mode::kInference);
  const Var said = network.forward(
      tape, tape.constant({1, MotionNoiseFeatures::kCount}, features.values.data()));
  return noise_factors(static_cast<double>(tape.data(said)[0]),
                       static_cast<double>(tape.data(said)[1]));
}

TrainedMotionNoise load_motion_noise(const std::string& file) {
  const auto weights = nn::WeightsFile::read(file);
  Random random(0);  // every number that it draws is replaced
  auto network = std::make_shared<MotionNoise<float>>(random);
  nn::ModelCard card = nn::load_network(weights, *network);
  return {std::move(network), weights.name(), std::move(card)};
}

}  // namespace imslam::vo
