#include "slam/adaptation/loss_agreement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace imslam::adaptation {
namespace {

constexpr std::size_t kFewestLooks = 5;

/// Ranks from 1, equal values with the mean of theirs.
std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> rank(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i;
    while (end < order.size() && values[order[end]] == values[order[i]]) ++end;
    const double mean = 0.5 * static_cast<double>(i + 1 + end);
    for (; i < end; ++i) rank[order[i]] = mean;
  }
  return rank;
}

LossAgreement::Verdict verdict_of(const LossAgreement& of) {
  if (!of.rank_correlation || of.looks < kFewestLooks) return LossAgreement::Verdict::kUnclear;
  const double bound = 1.645 / std::sqrt(static_cast<double>(of.looks - 1));
  if (*of.rank_correlation > bound) return LossAgreement::Verdict::kAgree;
  if (*of.rank_correlation < -bound) return LossAgreement::Verdict::kContradict;
  return LossAgreement::Verdict::kUnclear;
}

/// Empty without two looks that have both numbers.
std::optional<LossAgreement> agreement_with(const LearningLog& log, const char* error) {
  const auto losses = log.curves.find("held_out_loss");
  const auto errors = log.curves.find(error);
  if (losses == log.curves.end() || errors == log.curves.end()) return std::nullopt;
  std::vector<double> epoch;
  std::vector<double> x;
  std::vector<double> y;
  for (std::size_t i = 0; i < log.epoch.size(); ++i) {
    if (!std::isfinite(losses->second[i]) || !std::isfinite(errors->second[i])) continue;
    epoch.push_back(log.epoch[i]);
    x.push_back(losses->second[i]);
    y.push_back(errors->second[i]);
  }
  if (x.size() < 2) return std::nullopt;
  LossAgreement result;
  result.error = error;
  result.looks = x.size();
  result.rank_correlation = rank_correlation(x, y);
  const auto least = [](const std::vector<double>& values) {
    return static_cast<std::size_t>(std::min_element(values.begin(), values.end()) -
                                    values.begin());
  };
  result.chosen_epoch = epoch[least(x)];
  result.chosen_error = y[least(x)];
  result.first_error = y.front();
  result.best_epoch = epoch[least(y)];
  result.best_error = y[least(y)];
  result.verdict = verdict_of(result);
  return result;
}

double percent(double now, double before) { return 100.0 * (now - before) / before; }

}  // namespace

std::optional<double> rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size() || a.size() < 3) return std::nullopt;
  const std::vector<double> x = ranks(a);
  const std::vector<double> y = ranks(b);
  const double mean = 0.5 * static_cast<double>(a.size() + 1);
  double xx = 0.0;
  double yy = 0.0;
  double xy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean) * (x[i] - mean);
    yy += (y[i] - mean) * (y[i] - mean);
    xy += (x[i] - mean) * (y[i] - mean);
  }
  if (xx == 0.0 || yy == 0.0) return std::nullopt;
  return xy / std::sqrt(xx * yy);
}

std::string LossAgreement::sentence() const {
  std::string text = name;
  switch (verdict) {
    case Verdict::kAgree:
      text += fmt::format(": loss and true error agree (rank correlation {:+.2f} over {} looks).",
                          *rank_correlation, looks);
      break;
    case Verdict::kContradict:
      text += fmt::format(
          ": loss and true error CONTRADICT each other (rank correlation {:+.2f} over {} looks): "
          "on this sequence the self-supervision is not aligned with this error.",
          *rank_correlation, looks);
      break;
    case Verdict::kUnclear:
      text += rank_correlation && looks >= kFewestLooks
                  ? fmt::format(
                        ": no clear agreement (rank correlation {:+.2f} over {} looks is "
                        "within chance).",
                        *rank_correlation, looks)
                  : fmt::format(": {} looks are too few to tell.", looks);
  }
  return text + fmt::format(
                    " The epoch with the least loss ({:.0f}) has {:+.1f} % against the given "
                    "networks, the best one ({:.0f}) {:+.1f} %.",
                    chosen_epoch, percent(chosen_error, first_error), best_epoch,
                    percent(best_error, first_error));
}

std::vector<LossAgreement> loss_agreement(const LearningLog& log) {
  constexpr std::pair<const char*, const char*> kErrors[] = {
      {"graph_ate_m", "Graph ATE"},
      {"graph_rpe_m", "Graph RPE per frame [m]"},
      {"graph_rpe_deg", "Graph RPE per frame [deg]"},
      {"vo_ate_m", "VO ATE"},
      {"vo_rpe_m", "VO RPE per frame [m]"},
      {"vo_rpe_deg", "VO RPE per frame [deg]"},
      {"imu_rotation_deg", "IMU rotation over 5 s"},
      {"imu_position_m", "IMU position over 5 s"},
  };
  std::vector<LossAgreement> all;
  for (const auto& [error, name] : kErrors) {
    auto agreement = agreement_with(log, error);
    if (!agreement) continue;
    agreement->name = name;
    all.push_back(std::move(*agreement));
  }
  return all;
}

}  // namespace imslam::adaptation
