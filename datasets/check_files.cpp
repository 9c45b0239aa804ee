#include "datasets/check_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>

#include "datasets/image_index.hpp"
#include "datasets/imu_csv.hpp"
#include "datasets/stamp_file.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kListed = 3;  ///< findings of one kind that are listed one by one
constexpr double kClockJump_s = 60.0;

struct Stamp {
  std::int64_t time_ns = 0;
  std::size_t line = 0;
};

/// Goes through all rows; malformed ones become findings and are skipped.
void for_each_row(CsvReader& csv, Findings& findings, const std::function<void()>& row) {
  std::size_t malformed = 0;
  for (;;) {
    try {
      if (!csv.next()) break;
      row();
    } catch (const InputError& error) {
      if (++malformed <= kListed) findings.fail(error);
      if (malformed > 10000) break;  // not this kind of file at all
    }
  }
  if (malformed > kListed) {
    findings.fail(ExitCode::kData, fmt::format("{} more lines like these", malformed - kListed),
                  "see the first ones");
  }
}

std::int64_t median_step_ns(const std::vector<Stamp>& stamps) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i].time_ns > stamps[i - 1].time_ns) {
      steps.push_back(stamps[i].time_ns - stamps[i - 1].time_ns);
    }
  }
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// A sensor that seems to run above 20 kHz was stamped in microseconds or milliseconds.
void check_unit(const std::vector<Stamp>& stamps, const std::string& file, Findings& findings) {
  const std::int64_t step = median_step_ns(stamps);
  if (stamps.size() < 3 || step >= 50'000) return;
  const char* unit = step >= 100 ? "microseconds" : "milliseconds or seconds";
  findings.fail(
      ExitCode::kData,
      fmt::format("stamps advance by {} per line: they look like {}, not nanoseconds", step, unit),
      "convert all stamps to nanoseconds", file, stamps.front().line);
}

struct OrderLimits {
  std::int64_t lateness_ns;
  const char* thing;
};

void check_order(const std::vector<Stamp>& stamps,
                 const OrderLimits& limits,
                 const std::string& file,
                 Findings& findings) {
  std::size_t late = 0;
  std::size_t jumps = 0;
  Stamp latest{std::numeric_limits<std::int64_t>::min(), 0};
  std::size_t first_late_line = 0;
  for (const Stamp& stamp : stamps) {
    const bool first = latest.line == 0;
    const double step_s = first ? 0.0 : to_seconds(stamp.time_ns - latest.time_ns);
    if (std::abs(step_s) > kClockJump_s && ++jumps <= kListed) {
      findings.fail(ExitCode::kData, fmt::format("the clock jumps by {:+.3f} s", step_s),
                    "cut the recording here, or correct the stamps behind it", file, stamp.line);
    } else if (-step_s > to_seconds(limits.lateness_ns) && ++jumps <= kListed) {
      findings.fail(ExitCode::kData,
                    fmt::format("stamp is {:.3f} s before an earlier line, at most {:.2f} s can be "
                                "sorted",
                                -step_s, to_seconds(limits.lateness_ns)),
                    "sort the file by stamp", file, stamp.line);
    }
    if (step_s < 0.0 && late++ == 0) first_late_line = stamp.line;
    // After a jump the new clock counts, so that one jump is one finding.
    if (stamp.time_ns > latest.time_ns || std::abs(step_s) > kClockJump_s) latest = stamp;
  }
  if (late > 0) {
    findings.warn(fmt::format("{} {} stand behind later ones", late, limits.thing),
                  "they are sorted in; sort the file to silence this", file, first_late_line);
  }
}

bool same_values(const ImuSample& a, const ImuSample& b) {
  return a.angular_velocity == b.angular_velocity && a.linear_acceleration == b.linear_acceleration;
}

/// The line of the first sample with the stamp of an earlier one, and with its values or others.
std::size_t first_repetition(const std::vector<ImuRow>& rows, bool of_values) {
  std::map<std::int64_t, const ImuRow*> seen;
  for (const ImuRow& row : rows) {
    const auto [earlier, is_new] = seen.emplace(row.sample.time_ns, &row);
    if (!is_new && same_values(earlier->second->sample, row.sample) == of_values) return row.line;
  }
  return 0;
}

void check_imu_rows(const std::vector<ImuRow>& rows, const std::string& file, Findings& findings) {
  std::vector<Stamp> stamps;
  for (const ImuRow& row : rows) stamps.push_back({row.sample.time_ns, row.line});
  check_unit(stamps, file, findings);
  check_order(stamps, {kMaxImuLatenessNs, "samples"}, file, findings);
  const ImuTable table = clean_imu(rows, file, std::numeric_limits<std::int64_t>::max());
  const ImuCleaning& cleaning = table.cleaning;
  if (cleaning.not_finite > 0) {
    const auto first = std::find_if(rows.begin(), rows.end(), [](const ImuRow& row) {
      return !row.sample.angular_velocity.allFinite() ||
             !row.sample.linear_acceleration.allFinite();
    });
    findings.warn(fmt::format("{} samples hold nan or inf", cleaning.not_finite),
                  "they are dropped and the gap is bridged", file, first->line);
  }
  if (cleaning.repeated > 0) {
    findings.warn(fmt::format("{} samples are exact copies", cleaning.repeated), "they are dropped",
                  file, first_repetition(rows, true));
  }
  if (cleaning.conflicting > 0) {
    findings.warn(fmt::format("{} samples have the stamp of another", cleaning.conflicting),
                  "the first of each stamp is kept; check the recorder's clock", file,
                  first_repetition(rows, false));
  }
}

fs::path mav0_of(const fs::path& folder) {
  return fs::is_directory(folder / "mav0") ? folder / "mav0" : folder;
}

void check_times(const fs::path& file, Findings& findings) {
  try {
    read_times_file(file);
  } catch (const InputError& error) {
    findings.fail(error);
  }
}

}  // namespace

void check_imu_csv(const fs::path& file, Findings& findings) {
  try {
    CsvReader csv = open_imu_csv(LineReader(file));
    std::vector<ImuRow> rows;
    for_each_row(csv, findings, [&] { rows.push_back(imu_row(csv)); });
    if (csv.cut_off()) {
      findings.warn("the last line is cut off", "it is skipped; was the recording interrupted?",
                    file.string(), csv.line_number());
    }
    check_imu_rows(rows, file.string(), findings);
  } catch (const InputError& error) {
    findings.fail(error);
  }
}

void check_image_csv(const fs::path& file, Findings& findings) {
  try {
    using Kind = CsvColumn::Kind;
    CsvReader csv(LineReader(file), {{"time [ns]", Kind::kTime}, {"file name", Kind::kText}});
    std::vector<Stamp> stamps;
    for_each_row(csv, findings, [&] { stamps.push_back({csv.time_ns(0), csv.line_number()}); });
    check_unit(stamps, file.string(), findings);
    check_order(stamps, {kMaxImageLatenessNs, "images"}, file.string(), findings);
    std::sort(stamps.begin(), stamps.end(), [](const Stamp& a, const Stamp& b) {
      return a.time_ns < b.time_ns || (a.time_ns == b.time_ns && a.line < b.line);
    });
    const auto same =
        std::adjacent_find(stamps.begin(), stamps.end(),
                           [](const Stamp& a, const Stamp& b) { return a.time_ns == b.time_ns; });
    if (same != stamps.end()) {
      findings.warn("two images have one stamp", "the first of them is used", file.string(),
                    (same + 1)->line);
    }
  } catch (const InputError& error) {
    findings.fail(error);
  }
}

std::vector<fs::path> imu_files(const fs::path& folder) {
  return {mav0_of(folder) / "imu0" / "data.csv", folder / "imu.csv"};
}

void check_files(const fs::path& folder, Findings& findings) {
  const fs::path mav0 = mav0_of(folder);
  for (const fs::path& file : imu_files(folder)) {
    if (fs::exists(file)) check_imu_csv(file, findings);
  }
  for (const char* camera : {"cam0", "cam1"}) {
    const fs::path file = mav0 / camera / "data.csv";
    if (fs::exists(file)) check_image_csv(file, findings);
  }
  if (fs::exists(folder / "times.txt")) check_times(folder / "times.txt", findings);
}

}  // namespace imslam::datasets
