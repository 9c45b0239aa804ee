#include "slam/training/match_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"

namespace imslam::training {
namespace {

using nn::Index;

constexpr int kSeedOffset = 1'000'003;  // validation scenes and textures are others
constexpr double kOutlier = 3.0;        // [px]

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double percent_above(const std::vector<double>& values, double bound) {
  if (values.empty()) return 0.0;
  const auto count =
      std::count_if(values.begin(), values.end(), [&](double v) { return v > bound; });
  return 100.0 * static_cast<double>(count) / static_cast<double>(values.size());
}

/// |S^-1/2 e| with the scale matrix S of the prediction.
double normalised(const double* e, const float* log_sigma, Index D, double correlation) {
  const double x = e[0] / std::exp(static_cast<double>(log_sigma[0]));
  if (D == 1) return std::abs(x);
  const double y = e[1] / std::exp(static_cast<double>(log_sigma[1]));
  const double r = correlation;
  return std::sqrt(std::max(0.0, (x * x - 2.0 * r * x * y + y * y) / (1.0 - r * r)));
}

struct Lists {
  std::vector<double>& error_px;
  std::vector<double>& normalised;
  std::vector<double>& confidence;
};

void collect(const nn::Tape<float>& tape,
             const vo::MatchPrediction& p,
             const vo::MatchTruth<float>& truth,
             const Lists& lists) {
  const Index D = truth.displacement.shape().channels();
  for (Index i = 0; i < truth.valid.size(); ++i) {
    if (truth.valid[i] == 0.0F || truth.visible[i] == 0.0F) continue;
    std::array<double, 2> e{};
    for (Index d = 0; d < D; ++d) {
      e[static_cast<std::size_t>(d)] =
          static_cast<double>(tape.data(p.displacement)[D * i + d] - truth.displacement[D * i + d]);
    }
    const double r = D == 2 ? static_cast<double>(tape.data(p.correlation)[i]) : 0.0;
    lists.error_px.push_back(std::hypot(e[0], e[1]));
    lists.normalised.push_back(normalised(e.data(), tape.data(p.log_sigma) + D * i, D, r));
    lists.confidence.push_back(1.0 /
                               (1.0 + std::exp(-static_cast<double>(tape.data(p.confidence)[i]))));
  }
}

MatchQuality quality_of(const std::vector<double>& error_px,
                        const std::vector<double>& normalised,
                        const std::vector<double>& confidence) {
  std::vector<double> confident;
  for (std::size_t i = 0; i < error_px.size(); ++i) {
    if (confidence[i] > 0.5) confident.push_back(error_px[i]);
  }
  MatchQuality quality;
  quality.median_px = median(error_px);
  quality.outliers_percent = percent_above(error_px, kOutlier);
  quality.confident_percent = percent_above(confidence, 0.5);
  quality.confident_median_px = median(confident);
  quality.confident_outliers_percent = percent_above(confident, kOutlier);
  quality.normalised_median = median(normalised);
  return quality;
}

}  // namespace

const std::array<const char*, 4>& ValidationResult::names() {
  static const std::array<const char*, 4> kNames{"clean_flow", "clean_stereo", "degraded_flow",
                                                 "degraded_stereo"};
  return kNames;
}

std::string ValidationResult::text() const {
  std::string line = fmt::format("loss {:.4f}", loss);
  for (std::size_t i = 0; i < quality.size(); ++i) {
    const MatchQuality& q = quality[i];
    line +=
        fmt::format("; {} {:.3f} px, {:.1f} % > 3 px ({:.3f} px, {:.1f} % of the {:.0f} % sure)",
                    names()[i], q.median_px, q.outliers_percent, q.confident_median_px,
                    q.confident_outliers_percent, q.confident_percent);
  }
  return line;
}

std::string ValidationResult::columns() {
  std::string text;
  for (const char* name : names()) {
    for (const char* figure :
         {"median_px", "outliers_percent", "confident_percent", "confident_median_px",
          "confident_outliers_percent", "normalised_median"}) {
      text += fmt::format("{}{}_{}", text.empty() ? "" : ",", name, figure);
    }
  }
  return text;
}

std::string ValidationResult::row() const {
  std::string text;
  for (const MatchQuality& q : quality) {
    text += fmt::format("{}{:.4f},{:.3f},{:.2f},{:.4f},{:.3f},{:.3f}", text.empty() ? "" : ",",
                        q.median_px, q.outliers_percent, q.confident_percent, q.confident_median_px,
                        q.confident_outliers_percent, q.normalised_median);
  }
  return text;
}

MatchValidation::MatchValidation(const PretrainVoOptions& options) : options_(options) {
  TripletOptions triplets = options.triplets;
  triplets.seed += kSeedOffset;
  AugmentationOptions degradations = options.augmentation;
  degradations.seed += kSeedOffset;
  const TripletGenerator generator(triplets);
  const Augmentation augmentation(degradations);
  samples_.resize(static_cast<std::size_t>(options.validation_samples));
  parallel_for(samples_.size(), [&](std::size_t i) {
    Triplet triplet = generator.make(i);
    if (2 * i >= samples_.size()) augmentation.apply(i, 1.0, triplet);
    samples_[i] = draw_queries(triplet, options.queries,
                               Random(static_cast<std::uint64_t>(triplets.seed)).fork(i));
  });
}

MatchValidation::Errors MatchValidation::evaluate(vo::MatchNetwork<float>& network,
                                                  const MatchSample& sample) const {
  nn::Tape<float> tape(nn::Mode::kInference);
  const vo::FeaturePyramid features = network.encode(tape, tape.constant(sample.images));
  Errors errors;
  for (const vo::MatchKind kind : {vo::MatchKind::kFlow, vo::MatchKind::kStereo}) {
    const bool flow = kind == vo::MatchKind::kFlow;
    const vo::MatchTruth<float>& truth = flow ? sample.flow : sample.stereo;
    const vo::NetworkMatch match = match_sample(tape, network, features, sample, kind, false);
    errors.loss +=
        static_cast<double>(tape.number(match_loss(tape, match, truth, options_.loss).total));
    const std::size_t k = flow ? 0 : 1;
    collect(tape, match.prediction, truth,
            {errors.error_px[k], errors.normalised[k], errors.confidence[k]});
  }
  return errors;
}

ValidationResult MatchValidation::evaluate(vo::MatchNetwork<float>& network) const {
  std::vector<Errors> each(samples_.size());
  parallel_for(samples_.size(), [&](std::size_t i) { each[i] = evaluate(network, samples_[i]); });
  ValidationResult result;
  std::array<std::array<std::vector<double>, 3>, 4> all;
  for (std::size_t i = 0; i < each.size(); ++i) {
    result.loss += each[i].loss / static_cast<double>(each.size());
    for (std::size_t k = 0; k < 2; ++k) {
      auto& [error_px, normalised, confidence] = all[(2 * i >= each.size() ? 2 : 0) + k];
      const Errors& e = each[i];
      error_px.insert(error_px.end(), e.error_px[k].begin(), e.error_px[k].end());
      normalised.insert(normalised.end(), e.normalised[k].begin(), e.normalised[k].end());
      confidence.insert(confidence.end(), e.confidence[k].begin(), e.confidence[k].end());
    }
  }
  for (std::size_t k = 0; k < all.size(); ++k) {
    result.quality[k] = quality_of(all[k][0], all[k][1], all[k][2]);
  }
  return result;
}

}  // namespace imslam::training
