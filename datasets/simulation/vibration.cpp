#include "datasets/simulation/vibration.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

constexpr double kLowest_hz = 20.0;
constexpr double kHighest_hz = 200.0;
constexpr double kWander_s = 2.0;            ///< correlation time of frequencies and amplitudes
constexpr double kFrequencySigma = 0.03;     ///< of the logarithm
constexpr double kAmplitudeSigma = 0.4;      ///< of the logarithm
constexpr double kBlock_s = 0.05;            ///< the wandering proceeds in steps of this length
constexpr double kGyroPerAccel = 0.03;       ///< [rad/s per m/s^2], typical of small frames
constexpr double kGyroPerAccelSpread = 0.7;  ///< sigma of its logarithm

/// Mean 0, standard deviation 1, nearly normal: the sum of four uniform numbers out of one draw.
double rough_normal(std::uint64_t bits) {
  constexpr std::uint64_t kMask = 0xFFFF;
  const std::uint64_t sum =
      (bits & kMask) + ((bits >> 16U) & kMask) + ((bits >> 32U) & kMask) + (bits >> 48U);
  constexpr double kMean = 2.0 * 65535.0;
  constexpr double kSigma = 65536.0 * 0.57735026918962576;  // sqrt(4 / 12)
  return (static_cast<double>(sum) - kMean) / kSigma;
}

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

}  // namespace

Vibration::Vibration(double amplitude,
                     double rate_hz,
                     std::vector<VibrationLevel> levels,
                     const Random& random)
    : rate_hz_(rate_hz),
      levels_(std::move(levels)),
      random_(random),
      high_pass_(std::exp(-2.0 * M_PI * kLowest_hz / rate_hz)),
      block_(std::max<std::int64_t>(1, std::llround(kBlock_s * rate_hz))) {
  expects(rate_hz > 0.0, "Vibration: rate_hz must be positive");
  const double gyro_ratio = kGyroPerAccel * std::exp(kGyroPerAccelSpread * random_.normal());
  Axes units;
  units << Eigen::Vector3d::Constant(amplitude), Eigen::Vector3d::Constant(amplitude * gyro_ratio);

  const double tone_share = random_.uniform(0.3, 0.9);  // of the power
  const double tone_gain = std::sqrt(2.0 * tone_share / static_cast<double>(tones_.size()));
  for (Tone& tone : tones_) {
    tone.hertz = log_uniform(random_, kLowest_hz, kHighest_hz);
    tone.frequency_wander = kFrequencySigma * random_.normal();
    tone.amplitude_wander = kAmplitudeSigma * random_.normal();
    tone.phase = std::polar(1.0, random_.uniform(0.0, 2.0 * M_PI));
    for (int axis = 0; axis < 6; ++axis) {
      const double gain = tone_gain * units[axis] * random_.uniform(0.3, 1.6);
      const double phase = random_.uniform(0.0, 2.0 * M_PI);
      tone.cosine_gain[axis] = gain * std::cos(phase);
      tone.sine_gain[axis] = gain * std::sin(phase);
    }
  }
  // The high-pass leaves white noise a variance of 2 b^2 / (1 + b); a slow sensor sees less of the
  // band in the first place.
  const double seen = std::min(1.0, rate_hz / (2.0 * kHighest_hz));
  const double unit_gain = std::sqrt((1.0 + high_pass_) / 2.0) / high_pass_;
  for (int axis = 0; axis < 6; ++axis) {
    noise_gain_[axis] =
        std::sqrt((1.0 - tone_share) * seen) * unit_gain * units[axis] * random_.uniform(0.3, 1.6);
  }
}

void Vibration::wander() {
  const double memory = std::exp(-static_cast<double>(block_) / (rate_hz_ * kWander_s));
  const double news = std::sqrt(1.0 - memory * memory);
  for (Tone& tone : tones_) {
    tone.frequency_wander =
        memory * tone.frequency_wander + news * kFrequencySigma * random_.normal();
    tone.amplitude_wander =
        memory * tone.amplitude_wander + news * kAmplitudeSigma * random_.normal();
    const double hertz = tone.hertz * std::exp(tone.frequency_wander);
    const double low_pass = 1.0 / std::sqrt(1.0 + std::pow(hertz / (0.4 * rate_hz_), 4));
    tone.gain = low_pass * std::exp(tone.amplitude_wander);
    tone.turn = std::polar(1.0, 2.0 * M_PI * hertz / rate_hz_);
    tone.phase /= std::abs(tone.phase);
  }
}

VibrationLevel Vibration::level_at(double time_s) {
  while (cursor_ < levels_.size() && levels_[cursor_].time_s <= time_s) ++cursor_;
  if (levels_.empty()) return {};
  if (cursor_ == 0) return levels_.front();
  if (cursor_ == levels_.size()) return levels_.back();
  const VibrationLevel& before = levels_[cursor_ - 1];
  const VibrationLevel& after = levels_[cursor_];
  const double share = (time_s - before.time_s) / (after.time_s - before.time_s);
  return {time_s, before.tones + share * (after.tones - before.tones),
          before.broadband + share * (after.broadband - before.broadband)};
}

Vibration::Axes Vibration::noise() {
  Axes white;
  for (int axis = 0; axis < 6; ++axis) white[axis] = rough_normal(random_.bits());
  high_passed_ = high_pass_ * (high_passed_ + white - last_white_);
  last_white_ = white;
  return high_passed_;
}

Vibration::Reading Vibration::next(double time_s) {
  const VibrationLevel level = level_at(time_s);
  if (count_++ % block_ == 0) wander();
  Axes tones = Axes::Zero();
  for (Tone& tone : tones_) {
    const std::complex<double>& from = tone.phase;
    const std::complex<double>& by = tone.turn;
    tone.phase = {from.real() * by.real() - from.imag() * by.imag(),
                  from.real() * by.imag() + from.imag() * by.real()};
    tones +=
        tone.gain * (tone.phase.real() * tone.cosine_gain + tone.phase.imag() * tone.sine_gain);
  }
  const Axes sum = level.tones * tones + level.broadband * noise_gain_.cwiseProduct(noise());
  return {sum.tail<3>(), sum.head<3>()};
}

}  // namespace imslam::simulation
