#pragma once

#include <array>
#include <memory>
#include <string>

#include "slam/nn/layers/linear.hpp"
#include "slam/nn/model_card.hpp"
#include "vo_net/pose_layer.hpp"

namespace imslam::vo {

/// What a measured motion shows of its own quality; see motion_noise_features().
struct MotionNoiseFeatures {
  static constexpr int kCount = 9;
  std::array<float, kCount> values{};  ///< of the size of 1
};

/// From a valid pose and the correspondences behind it.
MotionNoiseFeatures motion_noise_features(const PoseLayerResult& pose,
                                          const Correspondences& correspondences,
                                          const StereoCamera& camera);

/// How far off the covariance of a pose is: it takes the errors of points for independent and the
/// camera model for exact.
///
///   Sigma = F Sigma_pose F,   F = diag(e^a, e^a, e^a, e^b, e^b, e^b)     [a b] = L tanh(mlp / L),
///   L = log 2
///
/// The last layer starts at zero: an untrained network changes nothing.
template <typename S>
struct MotionNoise {
  explicit MotionNoise(Random& random);

  /// features [N, MotionNoiseFeatures::kCount] -> [N, 2]: a of translation, b of rotation
  nn::Var forward(nn::Tape<S>& tape, nn::Var features) const;
  void collect(nn::ParameterList<S>& list, const std::string& prefix = "");

  nn::Linear<S> hidden, output;
};

/// F as a diagonal, from what the network says of one motion.
Eigen::Matrix<double, 6, 1> noise_factors(double translation, double rotation);
Eigen::Matrix<double, 6, 1> noise_factors(const MotionNoise<float>& network,
                                          const MotionNoiseFeatures& features);

/// What a folder of weights calls it, and what it was trained on.
struct TrainedMotionNoise {
  std::shared_ptr<MotionNoise<float>> network;
  std::string file;
  nn::ModelCard card;  ///< with the sha256 of the tensors, always
};

/// Throws InputError(kModel) if the file is not there, damaged or of another network.
TrainedMotionNoise load_motion_noise(const std::string& file);

}  // namespace imslam::vo
