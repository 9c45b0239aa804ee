#include "vo_net/match_inference.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "vo_net/network_pixels.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;

constexpr std::size_t kPointsPerTape = 100;  // pieces that do not depend on the number of threads

/// The features of one tape for use on another.
FeaturePyramid borrow(nn::Tape<float>& tape,
                      const nn::Tape<float>& owner,
                      const FeaturePyramid& features) {
  return {tape.borrow(owner, features.half), tape.borrow(owner, features.quarter),
          tape.borrow(owner, features.eighth), tape.borrow(owner, features.sixteenth)};
}

double sigmoid(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

/// Answer i of a prediction [1,P,D], in pixels of the network.
NetworkAnswer answer_of(const nn::Tape<float>& tape, const MatchPrediction& prediction, Index i) {
  const Index D = tape.shape(prediction.displacement).channels();
  const float* const moved = tape.data(prediction.displacement) + D * i;
  const float* const log_sigma = tape.data(prediction.log_sigma) + D * i;
  NetworkAnswer answer;
  answer.confidence = sigmoid(static_cast<double>(tape.data(prediction.confidence)[i]));
  const double sx = std::exp(static_cast<double>(log_sigma[0]));
  answer.displacement.x() = static_cast<double>(moved[0]);
  answer.covariance(0, 0) = kVarianceOfScale * sx * sx;
  if (D == 1) return answer;
  const double sy = std::exp(static_cast<double>(log_sigma[1]));
  const double r = static_cast<double>(tape.data(prediction.correlation)[i]);
  answer.displacement.y() = static_cast<double>(moved[1]);
  answer.covariance(1, 1) = kVarianceOfScale * sy * sy;
  answer.covariance(0, 1) = answer.covariance(1, 0) = kVarianceOfScale * r * sx * sy;
  return answer;
}

}  // namespace

MatchInference::MatchInference(std::shared_ptr<MatchNetwork<float>> network)
    : network_(std::move(network)),
      left_before_(std::make_unique<Encoded>()),
      left_(std::make_unique<Encoded>()),
      right_(std::make_unique<Encoded>()) {
  expects(network_ != nullptr, "MatchInference: needs a network");
}

void MatchInference::encode(Encoded& encoded) const {
  encoded.tape.reset();
  const Index height = encoded.image.height / shrink_;
  const Index width = encoded.image.width / shrink_;
  const Var pixels = encoded.tape.make({1, height, width, 1});
  write_network_pixels(encoded.image, shrink_, height, width, encoded.tape.data(pixels));
  encoded.features = network_->encode(encoded.tape, pixels);
  encoded.shrink = shrink_;
}

void MatchInference::advance(const GrayImage& left, const GrayImage& right, int shrink) {
  expects(shrink >= 1 && left.width >= shrink && left.height >= shrink &&
              left.width == right.width && left.height == right.height,
          "MatchInference::advance: two images of one size");
  std::swap(left_, left_before_);
  stereo_logits_ = {};
  shrink_ = shrink;
  left_->image = left;
  right_->image = right;
  const bool again = left_before_->shrink != 0 && left_before_->shrink != shrink;
  parallel_for(again ? 3 : 2, [&](std::size_t i) {
    encode(i == 0 ? *left_ : i == 1 ? *right_ : *left_before_);
  });
}

void MatchInference::step_back() {
  std::swap(left_, left_before_);
  left_before_->shrink = 0;
}

/// `from`: on the tape of `to`.
Var MatchInference::coarse_logits(const FeaturePyramid& from,
                                  Encoded& to,
                                  MatchKind kind,
                                  const MatchHint& hint) {
  return network_->coarse_logits(to.tape, from, to.features, kind, hint);
}

std::vector<NetworkAnswer> MatchInference::flow(const std::vector<Eigen::Vector2d>& points,
                                                const Eigen::Vector2d& predicted) {
  MatchHint hint;
  hint.predicted_x = predicted.x() / shrink_;
  hint.predicted_y = predicted.y() / shrink_;
  Pair pair{*left_before_, *left_, {}, MatchKind::kFlow, hint};
  // Both tasks want the newest left image, one of them writes on its tape: borrow before they part.
  const FeaturePyramid before = borrow(left_->tape, left_before_->tape, left_before_->features);
  const bool stereo_too = !stereo_logits_;
  const FeaturePyramid left =
      stereo_too ? borrow(right_->tape, left_->tape, left_->features) : FeaturePyramid();
  parallel_for(stereo_too ? 2 : 1, [&](std::size_t i) {  // on two tapes
    if (i == 0) {
      pair.coarse_logits = coarse_logits(before, *left_, pair.kind, hint);
    } else {
      stereo_logits_ = coarse_logits(left, *right_, MatchKind::kStereo, {});
    }
  });
  return match(pair, points);
}

std::vector<NetworkAnswer> MatchInference::stereo(const std::vector<Eigen::Vector2d>& points) {
  if (!stereo_logits_) {
    const FeaturePyramid left = borrow(right_->tape, left_->tape, left_->features);
    stereo_logits_ = coarse_logits(left, *right_, MatchKind::kStereo, {});
  }
  return match({*left_, *right_, stereo_logits_, MatchKind::kStereo, {}}, points);
}

std::vector<NetworkAnswer> MatchInference::match(const Pair& pair,
                                                 const std::vector<Eigen::Vector2d>& points) {
  std::vector<NetworkAnswer> answers(points.size());
  const std::size_t pieces = (points.size() + kPointsPerTape - 1) / kPointsPerTape;
  while (point_tapes_.size() < pieces) {
    point_tapes_.push_back(std::make_unique<nn::Tape<float>>(nn::Mode::kInference));
  }
  parallel_for(pieces, [&](std::size_t piece) {
    const std::size_t first = piece * kPointsPerTape;
    const std::size_t count = std::min(kPointsPerTape, points.size() - first);
    match_some(pair, *point_tapes_[piece], points.data() + first, static_cast<Index>(count),
               answers.data() + first);
  });
  return answers;
}

void MatchInference::match_some(const Pair& pair,
                                nn::Tape<float>& tape,
                                const Eigen::Vector2d* points,
                                Index count,
                                NetworkAnswer* answers) const {
  tape.reset();
  const Var places = tape.make({1, count, 2});
  const double middle = network_origin(shrink_);
  for (Index i = 0; i < count; ++i) {
    const Eigen::Vector2d place = (points[i].array() - middle) / shrink_;
    Eigen::Map<Eigen::Vector2f>(tape.data(places) + 2 * i) = place.cast<float>();
  }
  MatchHint hint = pair.hint;
  hint.coarse_logits = tape.borrow(pair.to.tape, pair.coarse_logits);
  const MatchPrediction prediction =
      network_
          ->forward(tape, borrow(tape, pair.from.tape, pair.from.features),
                    borrow(tape, pair.to.tape, pair.to.features), places, pair.kind, hint)
          .prediction;
  for (Index i = 0; i < count; ++i) {
    answers[i] = answer_of(tape, prediction, i);
    answers[i].displacement *= shrink_;
    answers[i].covariance *= shrink_ * shrink_;
  }
}

}  // namespace imslam::vo
