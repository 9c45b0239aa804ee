// Training triplets per second on one core, clean and with augmentation, by stage.
//
//   triplet_benchmark [--count 100] [--repeats 5] [--textures auto] [--sheet FILE.png]
//
// Minimum and median over the repeats, of this thread's CPU time: other processes hardly count.
// With --sheet FILE.png samples are drawn instead (--first, --samples, --ramp).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <functional>
#include <vector>

#include "slam/training/augmentation.hpp"
#include "slam/training/layer_truth.hpp"
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
  } else {
    bench::draw_sheet(settings, generator, augmentation);
  }
}
