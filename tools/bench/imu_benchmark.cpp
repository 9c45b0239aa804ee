// What the inertial front end costs per sample: the network's correction at several rates, and
// preintegration with and without its gradient. One thread, its own processor time. Weights are
// random: the time does not depend on them.
//
//   imu_benchmark [--seconds 30] [--repeats 8]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <functional>
#include <memory>
#include <vector>

#include "imu_net/imu_corrector.hpp"
#include "imu_net/preintegration.hpp"
#include "imu_net/preintegration_gradient.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/random.hpp"
#include "slam/base/time.hpp"

namespace imslam {
namespace {

std::vector<ImuSample> shaken_sensor(double rate_hz, double seconds) {
  Random random(1);
  std::vector<ImuSample> samples(static_cast<std::size_t>(seconds * rate_hz));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    samples[i].time_ns = to_nanoseconds(t);
    samples[i].angular_velocity = Eigen::Vector3d(std::sin(t), 0.3, 0.0) + 0.02 * random.normal3();
    samples[i].linear_acceleration = Eigen::Vector3d(0.0, std::cos(2.0 * t), 9.81);
    samples[i].linear_acceleration += 0.1 * random.normal3();
  }
  return samples;
}

double now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Other work on the machine makes single times long, never short: the smallest says most.
void measure(const std::string& what,
             std::size_t samples,
             int repeats,
             const std::function<void()>& work) {
  double least_s = 1e300;
  for (int i = -1; i < repeats; ++i) {
    const double start = now();
    work();
    if (i >= 0) least_s = std::min(least_s, now() - start);  // the first one allocates
  }
  fmt::print("{:<44}{:>12.0f}{:>12.0f}\n", what, 1e9 * least_s / static_cast<double>(samples),
             static_cast<double>(samples) / least_s);
}

void measure_network(double rate_hz, double seconds, int repeats) {
  const auto samples = shaken_sensor(rate_hz, seconds);
  Random random(2);
  const auto network = std::make_shared<imu::ImuNetwork<float>>(imu::ImuNetworkSizes(), random);
  ImuNoise noise;
  noise.rate_hz = rate_hz;
  measure(fmt::format("network, {:.0f} Hz", rate_hz), samples.size(), repeats, [&] {
    imu::ImuCorrector corrector(network, noise);
    for (const ImuSample& sample : samples) corrector.correct(sample);
  });
}

void measure_preintegration(double seconds, int repeats) {
  const auto samples = shaken_sensor(200.0, seconds);
  const imu::ImuRange range(samples);
  const auto count = static_cast<std::int64_t>(seconds / 0.1) - 1;
  imu::PreintegrationRecord record;
  std::vector<imu::SampleGradient> gradients(samples.size());
  imu::MotionGradient dL;
  dL.motion.setOnes();
  dL.covariance.setIdentity();
  const auto integrate = [&](imu::PreintegrationRecord* to) {
    for (std::int64_t k = 0; k < count; ++k) {
      imu::preintegrate(range, 100'000'000 * k, 100'000'000 * (k + 1), ImuBias(), ImuNoise(), 0.0,
                        {}, to);
      if (to != nullptr) imu::add_preintegration_gradient(*to, dL, gradients.data());
    }
  };
  measure("preintegration, 0.1 s at 200 Hz", samples.size(), repeats, [&] { integrate(nullptr); });
  measure("preintegration and gradient", samples.size(), repeats, [&] { integrate(&record); });
}

}  // namespace
}  // namespace imslam

int main(int argc, char** argv) {
  double seconds = 30.0;
  int repeats = 8;
  CLI::App app("What the inertial front end costs per sample");
  app.add_option("--seconds", seconds, "Length of the log")->check(CLI::Range(1.0, 1e4));
  app.add_option("--repeats", repeats, "Times")->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  imslam::set_thread_count(1);
  fmt::print("{:<44}{:>12}{:>12}\n", "one thread", "ns/sample", "samples/s");
  for (const double rate_hz : {50.0, 200.0, 1000.0}) {
    imslam::measure_network(rate_hz, seconds, repeats);
  }
  imslam::measure_preintegration(seconds, repeats);
  return 0;
}
