#pragma once

#include <array>
#include <string>
#include <vector>

#include "slam/training/pretrain_options.hpp"

namespace imslam::training {

/// How well matches of one kind agree with the truth, over valid, visible points.
struct MatchQuality {
  double median_px = 0.0;          ///< end-point error
  double outliers_percent = 0.0;   ///< of errors above 3 px
  double confident_percent = 0.0;  ///< of points with confidence > 0.5, and of those
  double confident_median_px = 0.0;
  double confident_outliers_percent = 0.0;
  double normalised_median =
      0.0;  ///< of error / predicted scale; 1.33 is right for flow, 0.77 for stereo
};

struct ValidationResult {
  double loss = 0.0;  ///< mean over all samples, as in training, own chain
  /// Clean flow, clean stereo, degraded flow, degraded stereo.
  std::array<MatchQuality, 4> quality;

  static const std::array<const char*, 4>& names();
  std::string text() const;  ///< one line
  std::string row() const;   ///< all figures, comma separated
  static std::string columns();
};

/// A fixed set of samples from seeds that training never draws: what chooses among weights.
class MatchValidation {
 public:
  explicit MatchValidation(const PretrainVoOptions& options);

  /// Runs the network as it is used: no teacher, norms with running statistics.
  ValidationResult evaluate(vo::MatchNetwork<float>& network) const;

 private:
  struct Errors {
    double loss = 0.0;
    std::array<std::vector<double>, 2> error_px, normalised, confidence;  ///< flow, stereo
  };
  Errors evaluate(vo::MatchNetwork<float>& network, const MatchSample& sample) const;

  PretrainVoOptions options_;
  std::vector<MatchSample> samples_;  ///< the first half clean
};

}  // namespace imslam::training
