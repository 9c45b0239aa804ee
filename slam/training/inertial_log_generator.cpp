#include "slam/training/inertial_log_generator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "slam/base/time.hpp"
#include "slam/training/inertial_motion.hpp"
#include "slam/training/inertial_sensor.hpp"
#include "slam/training/motion_tracks.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kEpoch_ns = 1'700'000'000'000'000'000;  ///< stamp of the first sample

/// Streams of a log.
enum : std::uint64_t { kKind, kMotion, kMounting, kSensor, kNoise, kStamps };

/// Who carries the sensor, and what that means for it.
struct Family {
  const char* name;
  InertialMotion (*motion)(double duration_s, Random random);
  double InertialLogOptions::*share;
  double lever_m;          ///< sigma of the place of the sensor, per axis
  double least_vibration;  ///< [m/s^2] rms
  double most_vibration;
};

constexpr Family kFamilies[] = {
    {"drone", drone_motion, &InertialLogOptions::drone_share, 0.03, 0.1, 4.0},
    {"hand", hand_motion, &InertialLogOptions::hand_share, 0.03, 0.0, 0.0},
    {"car", car_motion, &InertialLogOptions::car_share, 0.5, 0.05, 1.0},
    {"rover", rover_motion, &InertialLogOptions::rover_share, 0.15, 0.03, 1.0},
};

const Family& draw_family(const InertialLogOptions& options, Random& random) {
  double sum = 0.0;
  for (const Family& family : kFamilies) sum += options.*family.share;
  double chance = sum * random.uniform();
  const Family* last = nullptr;
  for (const Family& family : kFamilies) {
    if (options.*family.share <= 0.0) continue;
    last = &family;
    if ((chance -= options.*family.share) < 0.0) break;
  }
  return *last;
}

/// The poses of the sensor instead of the vehicle's.
simulation::MotionSpline spline_of(std::vector<lie::SE3d> T_world_vehicle,
                                   const lie::SE3d& T_vehicle_sensor) {
  for (lie::SE3d& T : T_world_vehicle) T = T * T_vehicle_sensor;
  return simulation::MotionSpline(kKnot_s, std::move(T_world_vehicle));
}

/// Stamps of a driver that reads late and early, never in the wrong order.
void jitter_stamps(double share, double rate_hz, std::vector<ImuSample>& samples, Random& random) {
  for (ImuSample& sample : samples) {
    sample.time_ns += to_nanoseconds(share * random.uniform(-1.0, 1.0) / rate_hz);
  }
}

/// Loses samples in one to four places, not at the ends.
void cut_gaps(std::vector<ImuSample>& samples, Random& random) {
  const std::int64_t first_ns = samples.front().time_ns;
  const double duration_s = to_seconds(samples.back().time_ns - first_ns);
  const std::int64_t gaps = random.integer(1, 4);
  for (std::int64_t gap = 0; gap < gaps; ++gap) {
    const double length_s = log_uniform(random, 0.05, 1.0);
    const std::int64_t begin_ns =
        first_ns + to_nanoseconds(random.uniform(0.5, duration_s - length_s - 0.5));
    const std::int64_t end_ns = begin_ns + to_nanoseconds(length_s);
    samples.erase(std::remove_if(samples.begin(), samples.end(),
                                 [&](const ImuSample& sample) {
                                   return sample.time_ns > begin_ns && sample.time_ns < end_ns;
                                 }),
                  samples.end());
  }
}

std::vector<ImuSample> read(const InertialScenario& scenario, const Random& random) {
  simulation::ImuModel model(scenario.errors, scenario.motion, kEpoch_ns, random,
                             scenario.vibration);
  const double rate_hz = scenario.errors.noise.rate_hz;
  const auto count = static_cast<std::size_t>(scenario.motion.duration_s() * rate_hz + 1e-9) + 1;
  std::vector<ImuSample> samples;
  samples.reserve(count);
  for (std::size_t i = 0; i < count; ++i) samples.push_back(model.next().reading);
  return samples;
}

std::vector<InertialLog::TrueState> truth_of(const simulation::MotionSpline& motion,
                                             const std::vector<ImuSample>& samples) {
  std::vector<InertialLog::TrueState> truth;
  const double period_s = InertialLogGenerator::kTruthPeriod_s;
  truth.reserve(static_cast<std::size_t>(motion.duration_s() / period_s) + 1);
  for (std::int64_t k = 0;; ++k) {
    const std::int64_t offset_ns = k * to_nanoseconds(period_s);
    const std::int64_t time_ns = kEpoch_ns + offset_ns;
    if (time_ns > samples.back().time_ns) return truth;
    if (time_ns < samples.front().time_ns) continue;
    const simulation::MotionState state = motion.at(to_seconds(offset_ns));
    truth.push_back({time_ns, {state.T_world_body, state.v_world}});
  }
}

InertialLogOptions validated(const InertialLogOptions& options) {
  options.validate();
  return options;
}

}  // namespace

InertialLogGenerator::InertialLogGenerator(const InertialLogOptions& options)
    : options_(validated(options)) {}

InertialScenario InertialLogGenerator::scenario(std::uint64_t index) const {
  const Random random = Random(static_cast<std::uint64_t>(options_.seed)).fork(index);
  Random kind = random.fork(kKind);
  const Family& family = draw_family(options_, kind);
  const double duration_s = kind.uniform(options_.min_duration_s, options_.max_duration_s);
  const double vibration = family.most_vibration > 0.0
                               ? log_uniform(kind, family.least_vibration, family.most_vibration)
                               : 0.0;
  Random mounting = random.fork(kMounting);
  const lie::SO3d R_vehicle_sensor = draw_mounting(mounting);
  const lie::SE3d T_vehicle_sensor(R_vehicle_sensor, family.lever_m * mounting.normal3());
  InertialMotion motion = family.motion(duration_s, random.fork(kMotion));
  return {family.name, spline_of(std::move(motion.T_world_vehicle), T_vehicle_sensor),
          T_vehicle_sensor, std::move(motion.vibration),
          draw_sensor(options_, vibration, random.fork(kSensor))};
}

InertialLog InertialLogGenerator::make(std::uint64_t index) const {
  const InertialScenario scenario = this->scenario(index);
  const Random random = Random(static_cast<std::uint64_t>(options_.seed)).fork(index);
  InertialLog log;
  log.name = fmt::format("{} {}", scenario.family, index);
  log.noise = scenario.errors.data_sheet;
  log.gravity_world = Vector3d(0.0, 0.0, -simulation::kGravity);
  log.samples = read(scenario, random.fork(kNoise));
  Random stamps = random.fork(kStamps);
  if (stamps.chance(options_.jitter_share)) {
    jitter_stamps(stamps.uniform(0.01, 0.1), log.noise.rate_hz, log.samples, stamps);
  }
  if (stamps.chance(options_.gap_share)) cut_gaps(log.samples, stamps);
  log.truth = truth_of(scenario.motion, log.samples);
  return log;
}

}  // namespace imslam::training
