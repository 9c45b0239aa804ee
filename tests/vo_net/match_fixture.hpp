#pragma once

#include <functional>
#include <vector>

#include "tests/vo_net/synthetic_images.hpp"
#include "vo_net/match_loss.hpp"

namespace imslam::testing {

/// A network that runs in milliseconds.
inline vo::MatchNetworkOptions tiny_match_network() {
  vo::MatchNetworkOptions o;
  o.half_channels = 6;
  o.quarter_channels = 8;
  o.eighth_channels = 12;
  o.sixteenth_channels = 12;
  o.sixteenth_features = 12;
  o.decoder_channels = 10;
  o.decoder_features = 8;
  o.head_channels = 16;
  o.flow_range = 2;
  o.stereo_range_left = 2;
  o.normalisation.small_radius = 3;
  o.normalisation.large_radius = 7;
  return o;
}

/// Random numbers in all parameters, also in those that start at 0 or 1.
template <typename S>
void shake(const nn::ParameterList<S>& parameters, Random& random, double size) {
  for (nn::Parameter<S>* parameter : parameters) {
    if (!parameter->trainable) continue;
    for (nn::Index i = 0; i < parameter->value.size(); ++i) {
      parameter->value[i] += static_cast<S>(random.uniform(-size, size));
    }
  }
}

struct Displacement {
  double x;
  double y;
};
using DisplacementField = std::function<Displacement(double x, double y)>;

/// Two images of a texture: what is at p in the first is at p + d(p) in the second.
struct TexturedPair {
  TexturedPair(std::uint64_t seed, nn::Index height, nn::Index width, DisplacementField field)
      : image0({1, height, width, 1}), image1({1, height, width, 1}), d(std::move(field)) {
    Random random(seed);
    const SplineTexture texture(random, 5.0);
    for (nn::Index i = 0; i < height; ++i) {
      for (nn::Index j = 0; j < width; ++j) {
        const auto x = static_cast<double>(j);
        const auto y = static_cast<double>(i);
        const Displacement moved = d(x, y);
        image0[i * width + j] = texture.at(x + moved.x, y + moved.y);
        image1[i * width + j] = texture.at(x, y);
      }
    }
  }

  /// Both as one batch [2,H,W,1], to be encoded together.
  nn::Tensor<double> images() const {
    nn::Tensor<double> both(image0.shape().with(0, 2));
    std::copy_n(image0.data(), image0.size(), both.data());
    std::copy_n(image1.data(), image1.size(), both.data() + image0.size());
    return both;
  }

  nn::Tensor<double> image0;
  nn::Tensor<double> image1;
  DisplacementField d;
};

/// Points [1,P,2] that stay `margin` away from the border.
inline nn::Tensor<double> random_points(
    Random& random, nn::Index count, nn::Index height, nn::Index width, double margin) {
  nn::Tensor<double> points({1, count, 2});
  for (nn::Index i = 0; i < count; ++i) {
    points[2 * i] = random.uniform(margin, static_cast<double>(width) - 1.0 - margin);
    points[2 * i + 1] = random.uniform(margin, static_cast<double>(height) - 1.0 - margin);
  }
  return points;
}

/// The truth at points of a pair: all valid and visible.
inline vo::MatchTruth<double> truth_at(const TexturedPair& pair,
                                       const nn::Tensor<double>& points,
                                       vo::MatchKind kind) {
  const nn::Index count = points.shape()[1];
  const nn::Index dimensions = kind == vo::MatchKind::kFlow ? 2 : 1;
  vo::MatchTruth<double> truth{nn::Tensor<double>({1, count, dimensions}),
                               nn::Tensor<double>({1, count}), nn::Tensor<double>({1, count})};
  truth.valid.array() = 1.0;
  truth.visible.array() = 1.0;
  for (nn::Index i = 0; i < count; ++i) {
    const Displacement moved = pair.d(points[2 * i], points[2 * i + 1]);
    truth.displacement[dimensions * i] = moved.x;
    if (dimensions == 2) truth.displacement[2 * i + 1] = moved.y;
  }
  return truth;
}

template <typename S>
vo::MatchTruth<S> cast_truth(const vo::MatchTruth<double>& truth) {
  return {nn::cast<S>(truth.displacement), nn::cast<S>(truth.valid), nn::cast<S>(truth.visible)};
}

template <typename S>
nn::ParameterList<S> parameters_of(vo::MatchNetwork<S>& network) {
  nn::ParameterList<S> list;
  network.collect(list);
  return list;
}

/// Encodes both images together and matches the points.
template <typename S>
vo::NetworkMatch match_pair(nn::Tape<S>& tape,
                            vo::MatchNetwork<S>& network,
                            const TexturedPair& pair,
                            const nn::Tensor<double>& points,
                            vo::MatchKind kind,
                            const vo::MatchHint& hint = {}) {
  const nn::Var images = tape.constant(nn::cast<S>(pair.images()));
  const vo::FeaturePyramid both = network.encode(tape, images);
  return network.forward(tape, vo::sample_of(tape, both, 0), vo::sample_of(tape, both, 1),
                         tape.constant(nn::cast<S>(points)), kind, hint);
}

}  // namespace imslam::testing
