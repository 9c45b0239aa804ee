#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/sequence.hpp"
#include "slam/system/run_recorder.hpp"
#include "slam/system/run_sequence.hpp"
#include "slam/system/slam_options.hpp"
#include "slam/system/suite_file.hpp"

namespace imslam::system {

/// How the runs of a suite are made.
struct SuiteRunSetup {
  SlamOptions options;
  RunProvenance provenance;      ///< without input_files
  std::filesystem::path folder;  ///< each run goes to <folder>/<sequence>
  bool force = false;            ///< run again whatever is there
  /// Before each run: may change its options and request, e.g. let the networks learn. What it
  /// returns lives until the run has ended.
  std::function<std::shared_ptr<void>(datasets::Sequence&, SlamOptions&, RunRequest&)> prepare;
  std::string networks = "zero-shot";  ///< see RunSummary
  std::function<bool()> stopped;
  std::function<void(const std::string& sequence, std::size_t done, std::size_t total)> progress;
};

/// What a run of a suite has left.
struct SuiteRun {
  nlohmann::json metrics;      ///< metrics.json
  bool tracking_lost = false;  ///< most of the frames were not measured
};

/// The runs of a suite with one set of options: made once, and kept for the next call.
///
/// A run in the folder is taken for this one if its suite.json says that it was made by the same
/// program (version and commit) with the same options and weights, on files of the same place,
/// names, sizes and, for all but the images, sha256. A run appears in the folder only when it is
/// complete, so that a killed one leaves nothing that could be taken for it.
class SuiteRuns {
 public:
  explicit SuiteRuns(SuiteRunSetup setup) : setup_(std::move(setup)) {}

  /// Throws what open_sequence() and run_sequence() throw, InputError(kOutput), and
  /// InputError(kInterrupted) if `stopped` was true before the end.
  const SuiteRun& run(const SuiteSequence& sequence, const std::filesystem::path& data);

 private:
  SuiteRun make(const SuiteSequence& sequence,
                datasets::Sequence& recording,
                const std::string& stamp);

  SuiteRunSetup setup_;
  std::map<std::string, SuiteRun> done_;  ///< by the name of the sequence
};

}  // namespace imslam::system
