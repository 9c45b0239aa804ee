#include "slam/training/imu_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "imu_net/correction_loss.hpp"
#include "imu_net/imu_corrector.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/text.hpp"
#include "slam/training/inertial_log_file.hpp"

namespace imslam::training {
namespace {

constexpr int kSeedOffset = 1'000'003;  // validation logs are others
constexpr double kLengths_s[] = {1.0, 5.0, 10.0};
constexpr std::size_t kLengthCount = 3;

std::vector<InertialLog> validation_logs(const ImuTrainingOptions& options) {
  if (!options.validation_logs.empty()) return read_inertial_logs(options.validation_logs);
  if (!options.logs.empty()) return read_inertial_logs(options.logs);
  auto others = options.simulation;
  others.seed += kSeedOffset;
  const InertialLogGenerator generator(others);
  std::vector<InertialLog> logs(static_cast<std::size_t>(options.validation_samples));
  parallel_for(logs.size(), [&](std::size_t i) { logs[i] = generator.make(i); });
  return logs;
}

/// The loss that correction_loss() gives this window.
double loss_of(const WindowError& window) {
  const double square = window.nees();
  const double log_det =
      2.0 * window.negative_log_likelihood() - square - 9.0 * std::log(2.0 * M_PI);
  return 0.5 * (imu::robust_square(square / 9.0) + log_det / 9.0);
}

double median_nees(const OpenIntegration& result) {
  std::vector<double> values;
  for (const WindowError& window : result.windows) values.push_back(window.nees() / 9.0);
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::vector<InertialLog> read_inertial_logs(const std::string& list) {
  std::vector<InertialLog> logs;
  if (list.empty()) return logs;
  for (const std::string_view path : split(list, ',')) {
    logs.push_back(read_inertial_log(std::string(trim(path))).log);
  }
  return logs;
}

std::string ImuQuality::text() const {
  return fmt::format(
      "loss {:.4f}; 10 s: rotation {:.2f} deg ({:.1f}x better than raw), position {:.2f} m "
      "({:.1f}x); NEES/9 median {:.2f}, {:.2f}, {:.2f} over 1, 5, 10 s; {:.0f} % inside 95 %",
      loss, rotation_deg, rotation_gain, position_m, position_gain, nees[0], nees[1], nees[2],
      100.0 * inside_95);
}

std::string ImuQuality::columns() {
  return "rotation_deg,rotation_gain,position_m,position_gain,nees_1s,nees_5s,nees_10s,inside_95";
}

std::string ImuQuality::row() const {
  return fmt::format("{:.4f},{:.3f},{:.4f},{:.3f},{:.4f},{:.4f},{:.4f},{:.4f}", rotation_deg,
                     rotation_gain, position_m, position_gain, nees[0], nees[1], nees[2],
                     inside_95);
}

ImuValidation::ImuValidation(const ImuTrainingOptions& options) : logs_(validation_logs(options)) {
  description_ = options.validation_logs.empty() && options.logs.empty()
                     ? fmt::format("{} validation logs of other seeds", logs_.size())
                     : "logs " + (options.validation_logs.empty() ? options.logs + " (in sample)"
                                                                  : options.validation_logs);
  for (const OpenIntegration& result : integrate_all(nullptr)) raw_.push_back(score(result));
}

std::vector<OpenIntegration> ImuValidation::integrate(const InertialLog& log,
                                                      const imu::ImuNetwork<float>* network) const {
  InertialCorrection correction;
  if (network == nullptr) {
    correction.corrected.samples = log.samples;
  } else {
    const std::shared_ptr<const imu::ImuNetwork<float>> borrowed(std::shared_ptr<void>(), network);
    correction.corrected = imu::correct_samples(borrowed, log.samples, log.noise);
  }
  std::vector<OpenIntegration> results;
  for (const double length_s : kLengths_s) {
    OpenIntegrationOptions options;
    options.window_s = length_s;
    results.push_back(integrate_open(log, correction, options));
  }
  return results;
}

std::vector<OpenIntegration> ImuValidation::integrate_all(
    const imu::ImuNetwork<float>* network) const {
  std::vector<std::vector<OpenIntegration>> each(logs_.size());
  parallel_for(logs_.size(), [&](std::size_t i) { each[i] = integrate(logs_[i], network); });
  std::vector<OpenIntegration> all(kLengthCount);
  for (const auto& results : each) {
    for (std::size_t k = 0; k < kLengthCount; ++k) {
      const auto& from = results[k].windows;
      all[k].windows.insert(all[k].windows.end(), from.begin(), from.end());
    }
  }
  return all;
}

ImuQuality ImuValidation::evaluate(const imu::ImuNetwork<float>& network) const {
  const auto results = integrate_all(&network);
  ImuQuality quality;
  double count = 0.0;
  for (std::size_t k = 0; k < kLengthCount; ++k) {
    const OpenScore scored = score(results[k]);
    quality.nees[k] = median_nees(results[k]);
    quality.inside_95 += scored.inside_95 * static_cast<double>(scored.windows);
    for (const WindowError& window : results[k].windows) quality.loss += loss_of(window);
    count += static_cast<double>(scored.windows);
    if (k + 1 < kLengthCount) continue;
    quality.rotation_deg = scored.rotation_rms_deg;
    quality.position_m = scored.position_rms;
    quality.rotation_gain = raw_[k].rotation_rms_deg / std::max(1e-9, scored.rotation_rms_deg);
    quality.position_gain = raw_[k].position_rms / std::max(1e-9, scored.position_rms);
  }
  quality.loss /= std::max(1.0, count);
  quality.inside_95 /= std::max(1.0, count);
  return quality;
}

}  // namespace imslam::training
