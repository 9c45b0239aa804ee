#include "slam/system/suite_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "datasets/check.hpp"
#include "datasets/open_sequence.hpp"
#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/system/front_end.hpp"
#include "slam/system/run_folder.hpp"
#include "slam/system/run_sequence.hpp"

namespace imslam::system {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

constexpr const char* kStamp = "suite.json";

/// "path size" of every file below `folder`, links followed: images that were exchanged for others
/// are noticed without reading them.
std::string listing(const fs::path& folder) {
  constexpr auto kOptions = fs::directory_options::follow_directory_symlink |
                            fs::directory_options::skip_permission_denied;
  std::vector<std::string> lines;
  std::error_code error;
  for (auto entry = fs::recursive_directory_iterator(folder, kOptions, error);
       !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    if (!entry->is_regular_file(ignored)) continue;
    lines.push_back(fmt::format("{} {}", entry->path().lexically_relative(folder).string(),
                                entry->file_size(ignored)));
  }
  std::sort(lines.begin(), lines.end());
  return fmt::format("{}", fmt::join(lines, "\n"));
}

std::string stamp_of(const datasets::Sequence& recording,
                     const SlamOptions& options,
                     const RunProvenance& provenance) {
  Json inputs = Json::array();
  for (const fs::path& file : recording.input_files()) {
    inputs.push_back(sha256(file.string()) + " " + sha256_of_file(file));
  }
  Json models = Json::array();
  for (const ModelRecord& model : make_front_end(options, recording.camera()).models) {
    models.push_back(model.name + " " + model.card.sha256);
  }
  const Json stamp = {{"program", provenance.version + " " + provenance.git_hash},
                      {"config", sha256(provenance.config_yaml)},
                      {"files", sha256(listing(recording.root()))},
                      {"frames", recording.frame_count()},
                      {"inputs", inputs},
                      {"models", models}};
  return stamp.dump();
}

/// The run in `folder`, if it is this one.
std::optional<SuiteRun> earlier_run(const fs::path& folder, const std::string& stamp) {
  std::error_code ignored;
  if (!fs::exists(folder / kStamp, ignored)) return std::nullopt;
  try {
    const Json kept = Json::parse(read_file(folder / kStamp));
    if (kept.at("stamp").get<std::string>() != stamp) return std::nullopt;
    return SuiteRun{Json::parse(read_file(folder / "metrics.json")),
                    kept.at("tracking_lost").get<bool>()};
  } catch (const Json::exception&) {
    return std::nullopt;  // damaged: made again
  } catch (const InputError&) {
    return std::nullopt;
  }
}

[[noreturn]] void fail_output(const fs::path& path, const std::error_code& error) {
  throw InputError(fmt::format("{}: cannot be written ({}); choose another place with --out",
                               path.string(), error.message()),
                   ExitCode::kOutput);
}

/// Puts a complete run in the place of an earlier one.
void publish(const fs::path& made, const fs::path& place) {
  if (fs::exists(place) && !fs::exists(place / "manifest.json")) {
    throw InputError(place.string() + ": holds something else than a run; name another --out",
                     ExitCode::kOutput);
  }
  std::error_code error;
  fs::create_directories(place.parent_path(), error);
  fs::remove_all(place, error);
  fs::rename(made, place, error);
  if (error) fail_output(place, error);
}

void expect_stereo_order(datasets::Sequence& recording) {
  const auto finding = datasets::check_stereo_order(recording);
  if (finding) throw InputError(finding->what + "; " + finding->remedy, ExitCode::kCalibration);
}

}  // namespace

const SuiteRun& SuiteRuns::run(const SuiteSequence& sequence, const fs::path& data) {
  const auto known = done_.find(sequence.name);
  if (known != done_.end()) return known->second;
  const auto stopped = [&] { return setup_.stopped && setup_.stopped(); };
  if (stopped()) throw InputError("not run: stopped before", ExitCode::kInterrupted);
  // Absolute: a relative path would name other files when called from elsewhere.
  const auto recording = datasets::open_sequence(fs::absolute(data).lexically_normal());
  const std::string stamp = stamp_of(*recording, setup_.options, setup_.provenance);
  if (!setup_.force) {
    if (auto kept = earlier_run(setup_.folder / sequence.name, stamp)) {
      log::info("{}: an earlier run in {} is used", sequence.name,
                (setup_.folder / sequence.name).string());
      return done_.emplace(sequence.name, *std::move(kept)).first->second;
    }
  }
  return done_.emplace(sequence.name, make(sequence, *recording, stamp)).first->second;
}

SuiteRun SuiteRuns::make(const SuiteSequence& sequence,
                         datasets::Sequence& recording,
                         const std::string& stamp) {
  RunRequest request;
  check_request(recording, setup_.options, request);
  expect_stereo_order(recording);
  request.keep_going = [&](std::size_t done, std::size_t total) {
    if (setup_.progress) setup_.progress(sequence.name, done, total);
    return !setup_.stopped || !setup_.stopped();
  };
  SlamOptions options = setup_.options;
  std::shared_ptr<void> kept;
  if (setup_.prepare) kept = setup_.prepare(recording, options, request);
  RunOutcome outcome = run_sequence(recording, options, request);
  outcome.summary.networks = setup_.networks;
  if (outcome.stopped) throw InputError("not run to its end: stopped", ExitCode::kInterrupted);

  const fs::path staging = setup_.folder / (".unfinished_" + sequence.name);
  std::error_code error;
  fs::remove_all(staging, error);  // of a call that was killed
  fs::create_directories(staging, error);
  if (error) fail_output(staging, error);
  RunProvenance provenance = setup_.provenance;
  provenance.input_files = recording.input_files();
  record_run(staging, outcome.result, outcome.summary, provenance, recording.camera(),
             outcome.evaluation, setup_.options.system.map_voxel_m);
  SuiteRun run{Json::parse(read_file(staging / "metrics.json")), outcome.result.tracking_lost};
  write_file_atomic(staging / kStamp,
                    Json{{"stamp", stamp}, {"tracking_lost", run.tracking_lost}}.dump(2) + "\n");
  publish(staging, setup_.folder / sequence.name);
  return run;
}

}  // namespace imslam::system
