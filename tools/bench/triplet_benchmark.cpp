// Training triplets per second on one core, clean and with augmentation, by stage.
//
//   triplet_benchmark [--count 100] [--repeats 5] [--textures auto] [--sheet FILE.png]
//
// Minimum and median over the repeats, of this thread's CPU time: other processes hardly count.
// Then what the clean samples ask of a matcher.
// With --sheet FILE.png samples are drawn instead (--first, --samples, --ramp).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "slam/training/augmentation.hpp"
#include "slam/training/triplet_generator.hpp"
#include "tools/bench/contact_sheet.hpp"

namespace imslam::bench {
namespace {

using training::Augmentation;
using training::Triplet;
using training::TripletGenerator;

struct Settings {
  int count = 100;
  int repeats = 5;
  double ramp = 1.0;
  int first = 0;
  int samples = 12;
  std::string sheet;
};

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void measure(const char* stage, const Settings& settings, const std::function<void(int)>& work) {
  std::vector<double> ms;
  for (int repeat = 0; repeat < settings.repeats; ++repeat) {
    const double start = cpu_ms();
    for (int i = 0; i < settings.count; ++i) work(i);
    ms.push_back((cpu_ms() - start) / settings.count);
  }
  std::sort(ms.begin(), ms.end());
  const double median = ms[ms.size() / 2];
  fmt::print("{:32} least {:6.2f} ms   median {:6.2f} ms   {:6.1f} per second\n", stage, ms[0],
             median, 1e3 / median);
}

void measure_all(const Settings& settings,
                 const TripletGenerator& generator,
                 const Augmentation& augmentation) {
  Triplet triplet;
  const auto sample = [&](int i) { generator.make(static_cast<std::uint64_t>(i), triplet); };
  measure("clean triplet", settings, sample);
  measure("clean and augmented triplet", settings, [&](int i) {
    sample(i);
    augmentation.apply(static_cast<std::uint64_t>(i), settings.ramp, triplet);
  });
  sample(0);
  measure("  augmentation alone", settings, [&](int i) {
    augmentation.apply(static_cast<std::uint64_t>(i), settings.ramp, triplet);
  });
}

void print_quantiles(const char* what, std::vector<float> values) {
  const auto at = [&](double share) {
    const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + place, values.end());
    return values[static_cast<std::size_t>(place)];
  };
  fmt::print("{:24} 5 % {:7.2f}   median {:7.2f}   95 % {:7.2f}   99.9 % {:7.2f}   most {:7.2f}\n",
             what, at(0.05), at(0.5), at(0.95), at(0.999), at(1.0));
}

void print_states(const char* what, const std::array<std::size_t, 4>& counts) {
  const double all = static_cast<double>(counts[0] + counts[1] + counts[2] + counts[3]);
  fmt::print(
      "{:24} visible {:.1f} %   hidden {:.1f} %   outside {:.1f} %   none {:.2f} %\n", what,
      100.0 * static_cast<double>(counts[0]) / all, 100.0 * static_cast<double>(counts[1]) / all,
      100.0 * static_cast<double>(counts[2]) / all, 100.0 * static_cast<double>(counts[3]) / all);
}

/// What the samples ask of a matcher; every 37th pixel is looked at.
void print_statistics(const Settings& settings, const TripletGenerator& generator) {
  std::vector<float> disparity;
  std::vector<float> flow;
  std::vector<float> contrast;
  std::array<std::size_t, 4> disparity_states{};
  std::array<std::size_t, 4> flow_states{};
  Triplet triplet;
  for (int i = 0; i < settings.count; ++i) {
    generator.make(static_cast<std::uint64_t>(i), triplet);
    for (std::size_t at = 0; at + 1 < triplet.disparity.size(); at += 37) {
      ++disparity_states[static_cast<std::size_t>(triplet.disparity_state[at])];
      ++flow_states[static_cast<std::size_t>(triplet.flow_state[at])];
      disparity.push_back(triplet.disparity[at]);
      contrast.push_back(std::abs(triplet.left0[at + 1] - triplet.left0[at]));
      if (triplet.flow_state[at] == training::MatchState::kVisible)
        flow.push_back(std::hypot(triplet.flow_u[at], triplet.flow_v[at]));
    }
  }
  print_quantiles("disparity [px]", std::move(disparity));
  print_quantiles("flow where visible [px]", std::move(flow));
  print_quantiles("neighbours differ [grey]", std::move(contrast));
  print_states("disparity", disparity_states);
  print_states("flow", flow_states);
}

void draw_sheet(const Settings& settings,
                const TripletGenerator& generator,
                const Augmentation& augmentation) {
  const auto samples = static_cast<std::size_t>(settings.samples);
  const auto first = static_cast<std::uint64_t>(settings.first);
  std::vector<Triplet> triplets = generator.batch(first, samples);
  for (std::size_t i = 0; i < samples; ++i)
    augmentation.apply(first + i, settings.ramp, triplets[i]);
  write_contact_sheet(triplets, settings.sheet);
}

}  // namespace
}  // namespace imslam::bench

int main(int count, char** arguments) {
  using namespace imslam;
  CLI::App app("Training triplets per second on one core");
  bench::Settings settings;
  training::TripletOptions options;
  app.add_option("--count", settings.count, "triplets per repeat")->check(CLI::Range(1, 100000));
  app.add_option("--repeats", settings.repeats)->check(CLI::Range(1, 1000));
  app.add_option("--textures", options.textures, "auto, photos or procedural");
  app.add_option("--texture-count", options.texture_count);
  app.add_option("--seed", options.seed);
  app.add_option("--ramp", settings.ramp, "strength of the augmentation")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--first", settings.first, "first sample of the sheet")
      ->check(CLI::Range(0, 1000000));
  app.add_option("--samples", settings.samples, "of the sheet")->check(CLI::Range(1, 100));
  app.add_option("--sheet", settings.sheet, "draw samples into this file instead");
  CLI11_PARSE(app, count, arguments);
  const double start = bench::cpu_ms();
  const training::TripletGenerator generator(options);
  fmt::print("textures: {}, made in {:.0f} ms of this thread\n", generator.description(),
             bench::cpu_ms() - start);
  const training::Augmentation augmentation({});
  if (settings.sheet.empty()) {
    bench::measure_all(settings, generator, augmentation);
    bench::print_statistics(settings, generator);
  } else {
    bench::draw_sheet(settings, generator, augmentation);
  }
}
