#include "slam/report/run_content.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"
#include "slam/base/time.hpp"

namespace imslam::report {
namespace {

constexpr double kMaxMagnitude = 1e9;  ///< [m] or [s]: beyond it a pose is nonsense

using Row = std::array<double, 8>;

Row parse_row(std::string_view line, const std::filesystem::path& file, std::size_t number) {
  const auto words = split_blanks(line);
  Row row{};
  bool good = words.size() == row.size();
  for (std::size_t i = 0; good && i < row.size(); ++i) {
    const auto value = parse_double(words[i]);
    good = value.has_value();
    row[i] = value.value_or(0.0);
  }
  if (!good) {
    throw InputError(fmt::format("{}:{}: expected 8 numbers 'seconds tx ty tz qx qy qz qw'",
                                 file.string(), number));
  }
  return row;
}

/// Finite, of sane size, with a rotation.
bool usable(const Row& row) {
  for (const double value : row) {
    if (!std::isfinite(value)) return false;
  }
  for (std::size_t i = 1; i < 4; ++i) {
    if (std::abs(row[i]) > kMaxMagnitude) return false;
  }
  const double norm = std::hypot(std::hypot(row[4], row[5]), std::hypot(row[6], row[7]));
  return norm > 1e-6 && norm < 1e6 && std::abs(row[0]) < 9e9;
}

/// Runs `read`; a missing file or an InputError becomes a note.
template <typename Read>
void try_read(RunContent& run,
              const std::filesystem::path& folder,
              const std::string& name,
              const std::string& consequence,
              const Read& read) {
  std::error_code error;
  if (!std::filesystem::exists(folder / name, error)) {
    if (!consequence.empty())
      run.notes.push_back(name + " is not in the run folder: " + consequence);
    return;
  }
  try {
    read(folder / name);
  } catch (const InputError& problem) {
    run.notes.push_back(name + " was left out: " + problem.what());
  }
}

}  // namespace

Trajectory read_tum(const std::filesystem::path& file, std::size_t* skipped) {
  const std::string text = read_file(file);
  Trajectory trajectory;
  std::size_t left_out = 0;
  std::size_t number = 0;
  for (const std::string_view raw : split(text, '\n')) {
    ++number;
    const std::string_view line = trim(raw);
    if (line.empty() || line[0] == '#') continue;
    const Row row = parse_row(line, file, number);
    const std::int64_t time_ns = usable(row) ? to_nanoseconds(row[0]) : 0;
    const bool later = trajectory.size() == 0 || time_ns > trajectory.times_ns.back();
    if (!usable(row) || !later) {
      ++left_out;
      continue;
    }
    const Eigen::Quaterniond rotation(row[7], row[4], row[5], row[6]);
    trajectory.add(time_ns, lie::SE3d(lie::SO3d(rotation), {row[1], row[2], row[3]}));
  }
  if (skipped != nullptr) *skipped = left_out;
  return trajectory;
}

RunContent read_run(const std::filesystem::path& run_folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(run_folder, error)) {
    throw InputError(run_folder.string() + ": expected a run folder; do `imslam run` first");
  }
  RunContent run;
  run.name = std::filesystem::weakly_canonical(run_folder, error).filename().string();

  const auto text = [&](const std::string& name, const std::string& consequence, std::string& out) {
    try_read(run, run_folder, name, consequence, [&](const auto& file) { out = read_file(file); });
  };
  text("metrics.json", "no figures are shown.", run.metrics_json);
  text("series.json", "no plots over time are shown.", run.series_json);
  text("config.yaml", "the settings are not shown.", run.config_yaml);
  text("manifest.json", "versions and hashes are not shown.", run.manifest_json);

  const auto poses = [&](const std::string& name, const std::string& consequence, Trajectory& out) {
    try_read(run, run_folder, name, consequence, [&](const auto& file) {
      std::size_t skipped = 0;
      out = read_tum(file, &skipped);
      if (skipped > 0) {
        run.notes.push_back(
            fmt::format("{}: {} lines without a valid pose are left out.", name, skipped));
      }
    });
  };
  poses("trajectory.tum", "the estimated trajectory is not shown.", run.graph);
  poses("vo_only.tum", "", run.vo);
  poses("truth.tum", "there is no ground truth, so no errors are shown.", run.truth);
  try_read(run, run_folder, "map.pcd", "",
           [&](const auto& file) { run.map = read_pcd(file, kMaxMapPoints); });
  return run;
}

}  // namespace imslam::report
