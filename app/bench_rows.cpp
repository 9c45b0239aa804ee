#include "app/bench_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>

#include "app/interrupt.hpp"
#include "app/version.hpp"
#include "slam/adaptation/finetune.hpp"
#include "slam/adaptation/online_adapter.hpp"
#include "slam/base/progress.hpp"
#include "slam/base/text.hpp"
#include "slam/system/suite_runs.hpp"

namespace imslam::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kOnline = "adapted online";
constexpr const char* kAdapted = "adapted to this sequence before the run";

/// A row that this command knows.
struct Variant {
  std::string key;
  std::string row;
  std::string run;    ///< folder of the runs that it is taken from
  std::string block;  ///< of metrics.json
  bool imu = false;
  std::string networks = "zero-shot";
};

const std::vector<Variant>& variants() {
  static const std::vector<Variant> all = {
      {"vo", "imslam zero-shot, VO only", "vision", "vo", false},
      {"vision", "imslam zero-shot, graph without IMU", "vision", "graph", false},
      {"graph", "imslam zero-shot, with IMU", "inertial", "graph", true},
      {"online_vo", "imslam online-adapted, VO of that run", "online", "vo", true, kOnline},
      {"online", "imslam online-adapted, with IMU", "online", "graph", true, kOnline},
      {"adapted_vo", "imslam adapted, VO of that run", "adapted", "vo", true, kAdapted},
      {"adapted", "imslam adapted, with IMU", "adapted", "graph", true, kAdapted}};
  return all;
}

std::vector<Variant> chosen_variants(const std::string& text) {
  std::vector<Variant> chosen;
  std::vector<std::string> names;
  for (const Variant& each : variants()) names.push_back(each.key);
  for (const std::string_view word : split(text, ',')) {
    const auto found = std::find(names.begin(), names.end(), trim(word));
    if (found == names.end()) {
      const auto nearest = nearest_name(word, names);
      throw InputError(fmt::format("--variants: unknown row '{}'{}; known are {}", word,
                                   nearest ? fmt::format(", did you mean '{}'?", *nearest) : "",
                                   fmt::join(names, ", ")),
                       ExitCode::kUsage);
    }
    chosen.push_back(variants()[static_cast<std::size_t>(found - names.begin())]);
  }
  return chosen;
}

/// The options of one kind of run: suite's config < layers < flags.
void apply_options(const BenchArguments& arguments,
                   const system::Suite& suite,
                   bool imu,
                   bool learns,
                   Settings& settings) {
  Config& config = settings.config();
  if (!suite.config.empty()) config.load_file(find_config(suite.config));
  arguments.layers.apply(settings);
  if (!arguments.weights_vo.empty()) {
    config.set("vo.learned.weights=" + fs::absolute(arguments.weights_vo).string(), "--weights-vo");
    config.set("system.front_end=learned", "--weights-vo");
  }
  if (!arguments.front_end.empty()) {
    config.set("system.front_end=" + arguments.front_end, "--front-end");
  }
  if (!imu) config.set("system.imu=off", "variant");
  if (learns) {
    config.set("system.front_end=learned", "variant");
    config.set("system.imu=learned", "variant");
  }
  settings.validate();
  if (imu && settings.slam().system.imu == "off") {
    throw InputError("system.imu is off: leave row 'graph' out (--variants vo,vision)",
                     ExitCode::kUsage);
  }
}

using Prepare = decltype(system::SuiteRunSetup::prepare);

/// The networks learn from the past while the run goes on.
Prepare learn_online(const adaptation::AdaptationOptions& adaptation) {
  return [adaptation](datasets::Sequence& sequence, system::SlamOptions& options,
                      system::RunRequest& request) {
    auto adapter = std::make_shared<adaptation::OnlineAdapter>(options, adaptation, sequence);
    adapter->attach(request);
    return std::shared_ptr<void>(adapter);
  };
}

/// The graph teaches the networks on the sequence, then the run uses them.
Prepare learn_before(const adaptation::AdaptationOptions& adaptation,
                     const fs::path& folder,
                     bool force) {
  return [adaptation, folder, force](datasets::Sequence& sequence, system::SlamOptions& options,
                                     system::RunRequest& request) {
    system::RunRequest quiet;
    quiet.keep_going = [](std::size_t, std::size_t) { return !interrupted(); };
    system::SlamOptions teaching = options;
    if (teaching.pgo.kernel == "cauchy_tail") {
      teaching.pgo.kernel = adaptation::kTeachingKernel;
      teaching.pgo.kernel_width = adaptation::kTeachingKernelWidth;
    }
    const adaptation::EpochRequest epoch{sequence, teaching, adaptation, quiet};
    learner::TrainingRequest training;
    training.folder = folder / sequence.name();
    training.resume = !force;
    training.force = force;
    training.command = "imslam bench";
    training.keep_going = [](int, int, const std::string&) { return !interrupted(); };
    Config config;
    adaptation::AdaptationOptions printed = adaptation;
    config.section("finetune", printed);
    const auto outcome =
        adaptation::finetune({epoch}, config.to_yaml(), training, *single_process(), {});
    if (outcome.training.stopped) throw InputError("stopped", ExitCode::kInterrupted);
    adaptation::use_networks(training.folder / "weights", options);
    request.networks = nullptr;
    return std::shared_ptr<void>();
  };
}

std::shared_ptr<system::SuiteRuns> make_runs(const BenchArguments& arguments,
                                             const CommonOptions& common,
                                             const system::Suite& suite,
                                             const Variant& variant,
                                             const fs::path& out,
                                             bool show_progress) {
  Settings settings;
  apply_options(arguments, suite, variant.imu, variant.networks != "zero-shot", settings);
  system::SuiteRunSetup setup;
  setup.networks = variant.networks;
  if (variant.networks == kOnline) setup.prepare = learn_online(settings.adaptation());
  if (variant.networks == kAdapted) {
    setup.prepare = learn_before(settings.adaptation(), out / "finetune", arguments.force);
  }
  setup.options = settings.slam();
  setup.provenance.version = version_text();
  setup.provenance.git_hash = git_hash();
  setup.provenance.command_line = common.command_line;
  setup.provenance.seed = static_cast<std::uint64_t>(settings.slam().system.seed);
  setup.provenance.config_yaml = settings.config().to_yaml();
  setup.folder = out / variant.run;
  setup.force = arguments.force;
  setup.stopped = [] { return interrupted(); };
  if (show_progress) {
    auto bar = std::make_shared<ProgressBar>(variant.run);
    setup.progress = [bar](const std::string& sequence, std::size_t done, std::size_t total) {
      bar->update(done, total, sequence);
      if (done == total) bar->clear();
    };
  }
  return std::make_shared<system::SuiteRuns>(std::move(setup));
}

system::SuiteCell cell_of(const system::SuiteRun& run,
                          const Variant& variant,
                          const std::vector<system::SuiteFigure>& figures) {
  if (run.tracking_lost) return {{}, "tracking lost", ExitCode::kTrackingLost};
  if (variant.imu && !run.metrics.at("inertial").get<bool>()) {
    return {{}, "no IMU data", ExitCode::kData};
  }
  return system::suite_cell(run.metrics, variant.block, figures);
}

}  // namespace

std::vector<system::SuiteMethod> make_methods(const BenchArguments& arguments,
                                              const CommonOptions& common,
                                              const system::Suite& suite,
                                              const fs::path& out,
                                              bool show_progress) {
  std::map<std::string, std::shared_ptr<system::SuiteRuns>> runs;  // shared by rows
  std::vector<system::SuiteMethod> methods;
  for (const Variant& variant : chosen_variants(arguments.variants)) {
    auto& shared = runs[variant.run];
    if (!shared) shared = make_runs(arguments, common, suite, variant, out, show_progress);
    methods.push_back({variant.row, [shared, variant, figures = suite.figures()](
                                        const auto& sequence, const fs::path& data) {
                         return cell_of(shared->run(sequence, data), variant, figures);
                       }});
  }
  return methods;
}

}  // namespace imslam::app
