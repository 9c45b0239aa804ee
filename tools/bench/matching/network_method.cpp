#include <algorithm>
#include <cmath>

#include "slam/nn/weights_io.hpp"
#include "tools/bench/matching/method.hpp"
#include "vo_net/match_network.hpp"
#include "vo_net/match_polish.hpp"

namespace imslam::bench {
namespace {

using nn::Index;
using nn::Tape;
using nn::Var;
using vo::ImagePyramid;
using vo::MatchKind;

using Points = std::vector<Eigen::Vector2d>;

constexpr double kConfident = 0.5;

nn::Tensor<float> tensor_of(const GrayImage& image) {
  nn::Tensor<float> tensor({1, image.height, image.width, 1});
  std::copy(image.pixels.begin(), image.pixels.end(), tensor.data());
  return tensor;
}

nn::Tensor<float> tensor_of(const Points& points) {
  nn::Tensor<float> tensor({1, static_cast<Index>(points.size()), 2});
  for (std::size_t i = 0; i < points.size(); ++i) {
    tensor[static_cast<Index>(2 * i)] = static_cast<float>(points[i].x());
    tensor[static_cast<Index>(2 * i + 1)] = static_cast<float>(points[i].y());
  }
  return tensor;
}

/// What the network says of point i.
PointMatch match_of(const Tape<float>& tape,
                    const vo::MatchPrediction& prediction,
                    MatchKind kind,
                    std::size_t i) {
  const auto number = [&](Var v, std::size_t at) { return static_cast<double>(tape.data(v)[at]); };
  PointMatch match;
  StatedUncertainty stated;
  if (kind == MatchKind::kFlow) {
    match.displacement = {number(prediction.displacement, 2 * i),
                          number(prediction.displacement, 2 * i + 1)};
    const double sx = std::exp(number(prediction.log_sigma, 2 * i));
    const double sy = std::exp(number(prediction.log_sigma, 2 * i + 1));
    const double both = number(prediction.correlation, i) * sx * sy;
    stated.scale << sx * sx, both, both, sy * sy;
  } else {
    match.displacement = {number(prediction.displacement, i), 0.0};
    stated.scale(0, 0) = std::exp(2.0 * number(prediction.log_sigma, i));
  }
  stated.confidence = 1.0 / (1.0 + std::exp(-number(prediction.confidence, i)));
  match.answered = true;
  match.accepted = stated.confidence > kConfident;
  match.score = stated.confidence;
  match.uncertainty = stated;
  return match;
}

/// The polish of the front end, from where the network thinks the point is.
class Polisher {
 public:
  Polisher(MatchKind kind, const GrayImage& image0, const GrayImage& image1)
      : kind_(kind),
        options_(vo::LearnedMatcherOptions().for_width(image0.width)),
        polish_(options_) {
    const int levels = options_.coarse_polish + 1;
    from_.build(image0, levels, options_.smoothing);
    to_.build(image1, levels, options_.smoothing);
  }

  PointMatch polished(PointMatch match, const Eigen::Vector2d& point) const {
    const bool stereo = kind_ == MatchKind::kStereo;
    vo::NetworkAnswer said;
    said.displacement = match.displacement;
    said.covariance = kVariancePerScale * match.uncertainty->scale;
    if (stereo) said.covariance(1, 1) = 0.0;
    match.uncertainty.reset();  // it spoke of the place before
    auto better = polish_.polish(from_, point, to_, said);
    if (!better && !stereo) better = polish_.polish_coarse(from_, point, to_, said);
    if (!better) return match;
    const Eigen::Vector2d displacement = better->position - point;
    if (stereo && std::abs(displacement.y()) > options_.max_row_error) return match;
    match.displacement = stereo ? Eigen::Vector2d(displacement.x(), 0.0) : displacement;
    return match;
  }

 private:
  static constexpr double kVariancePerScale = 3.0;  // of Student's t with 3 degrees of freedom

  MatchKind kind_;
  vo::LearnedMatcherOptions options_;
  vo::MatchPolish polish_;
  ImagePyramid from_, to_;
};

class NetworkMethod final : public Method {
 public:
  explicit NetworkMethod(const std::filesystem::path& weights) : network_(initialised()) {
    nn::ParameterList<float> parameters;
    network_.collect(parameters);
    nn::load_parameters(nn::WeightsFile::read(weights), parameters);
    network_.fold();
  }

  std::vector<std::string> names(MatchKind) const override { return {kRaw, kPolished}; }

  std::vector<Answer> match(MatchKind kind,
                            const GrayImage& image0,
                            const GrayImage& image1,
                            const Points& points) const override {
    Tape<float> tape(nn::Mode::kInference);
    const vo::FeaturePyramid features0 = network_.encode(tape, tape.constant(tensor_of(image0)));
    const vo::FeaturePyramid features1 = network_.encode(tape, tape.constant(tensor_of(image1)));
    const vo::MatchPrediction prediction =
        network_.forward(tape, features0, features1, tape.constant(tensor_of(points)), kind)
            .prediction;
    const Polisher polisher(kind, image0, image1);
    Answer raw{kRaw, {}};
    Answer polished{kPolished, {}};
    for (std::size_t i = 0; i < points.size(); ++i) {
      raw.matches.push_back(match_of(tape, prediction, kind, i));
      polished.matches.push_back(polisher.polished(raw.matches.back(), points[i]));
    }
    return {raw, polished};
  }

 private:
  static constexpr const char* kRaw = "network";
  static constexpr const char* kPolished = "network+LK";

  static vo::MatchNetwork<float> initialised() {
    Random random(1);  // every number is loaded afterwards
    return vo::MatchNetwork<float>({}, random);
  }

  // Inference reads the parameters only.
  mutable vo::MatchNetwork<float> network_;
};

}  // namespace

std::unique_ptr<Method> make_network(const std::filesystem::path& weights) {
  return std::make_unique<NetworkMethod>(weights);
}

}  // namespace imslam::bench
