#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slam/adaptation/learning_log.hpp"

namespace imslam::adaptation {

/// Whether the self-supervised loss and a true error rank the epochs alike.
struct LossAgreement {
  enum class Verdict { kAgree, kUnclear, kContradict };

  std::string error;      ///< name in EpochScores::columns()
  std::string name;       ///< for people
  std::size_t looks = 0;  ///< with both numbers
  /// Spearman's, between held-out loss and error; empty if one of them never changes.
  std::optional<double> rank_correlation;
  Verdict verdict = Verdict::kUnclear;
  double chosen_epoch = 0.0;  ///< of the least loss,
  double chosen_error = 0.0;  ///< with this error,
  double first_error = 0.0;   ///< where the networks as given have this one
  double best_epoch = 0.0;    ///< of the least error,
  double best_error = 0.0;    ///< with this one

  std::string sentence() const;
};

/// Spearman's rank correlation, ties with their mean rank. Empty below 3 pairs, or if all of one
/// side are equal.
std::optional<double> rank_correlation(const std::vector<double>& a, const std::vector<double>& b);

/// For every error of the log that has truth. kAgree and kContradict: beyond what 1 of 20 random
/// rankings of as many looks reaches (|r| > 1.645 / sqrt(looks - 1)), of 5 or more looks.
std::vector<LossAgreement> loss_agreement(const LearningLog& log);

}  // namespace imslam::adaptation
