#include "slam/training/inertial_methods.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "imu_net/gravity_alignment.hpp"
#include "slam/base/time.hpp"

namespace imslam::training {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kSearchStep_ns = kSecond_ns / 4;

InertialMethod::Result uncorrected(const InertialLog& log) {
  InertialMethod::Result result;
  result.correction.corrected.samples = log.samples;
  return result;
}

/// What the truth says about the rest: smooth straight travel looks alike.
std::string true_speed(const InertialLog& log, std::int64_t time_ns) {
  for (const InertialLog::TrueState& state : log.truth) {
    if (state.time_ns < time_ns) continue;
    if (state.time_ns > time_ns + kSecond_ns) break;
    return fmt::format("; true speed {:.2f} m/s", state.nav.v_world.norm());
  }
  return "";
}

InertialMethod::Result remove_rest_bias(const InertialLog& log,
                                        const imu::StaticDetectorOptions& options) {
  InertialMethod::Result result = uncorrected(log);
  const auto start_ns = first_still_second(log, options);
  const auto rest =
      start_ns ? imu::align_to_gravity(log.samples, *start_ns, log.noise, options) : std::nullopt;
  if (!rest) {
    result.remark = "never at rest: as raw";
    return result;
  }
  auto& corrected = result.correction.corrected;
  for (ImuSample& sample : corrected.samples) sample.angular_velocity -= rest->bias.gyro;
  const double walk_squared = log.noise.gyro_random_walk * log.noise.gyro_random_walk;
  for (std::int64_t t = log.samples.front().time_ns; t <= log.samples.back().time_ns;
       t += kSecond_ns) {
    const double away_s = std::abs(to_seconds(t - *start_ns));
    imu::StampedBiasSigma entry;
    entry.time_ns = t;
    entry.sigma.gyro =
        (rest->gyro_bias_covariance.diagonal().array() + walk_squared * away_s).sqrt();
    entry.sigma.accel.setConstant(log.noise.accel_bias_sigma);
    corrected.bias_sigma.push_back(entry);
  }
  result.remark =
      fmt::format("seems at rest {:.2f} s after the first sample{}",
                  to_seconds(*start_ns - log.samples.front().time_ns), true_speed(log, *start_ns));
  return result;
}

}  // namespace

InertialMethod raw_method() { return {"raw", uncorrected}; }

InertialMethod rest_bias_method(const imu::StaticDetectorOptions& options) {
  return {"rest bias",
          [options](const InertialLog& log) { return remove_rest_bias(log, options); }};
}

InertialMethod corrected_method(std::string name,
                                std::function<imu::CorrectedSamples(const InertialLog&)> correct) {
  return {std::move(name), [correct = std::move(correct)](const InertialLog& log) {
            InertialMethod::Result result;
            result.correction.corrected = correct(log);
            return result;
          }};
}

std::optional<std::int64_t> first_still_second(const InertialLog& log,
                                               const imu::StaticDetectorOptions& options) {
  const std::int64_t last_ns = log.samples.back().time_ns - kSecond_ns;
  for (std::int64_t t = log.samples.front().time_ns; t <= last_ns; t += kSearchStep_ns) {
    if (imu::assess_stillness(log.samples, t, t + kSecond_ns, log.noise, options).still) return t;
  }
  return std::nullopt;
}

}  // namespace imslam::training
