#include "datasets/imu_csv.hpp"

#include <algorithm>
#include <limits>

#include "slam/base/log.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

bool same_reading(const ImuSample& a, const ImuSample& b) {
  return a.angular_velocity == b.angular_velocity && a.linear_acceleration == b.linear_acceleration;
}

void drop_not_finite(std::vector<ImuRow>& rows, ImuCleaning& cleaning) {
  const auto end = std::remove_if(rows.begin(), rows.end(), [](const ImuRow& row) {
    return !row.sample.angular_velocity.allFinite() || !row.sample.linear_acceleration.allFinite();
  });
  cleaning.not_finite = static_cast<std::size_t>(rows.end() - end);
  rows.erase(end, rows.end());
}

void sort_late(std::vector<ImuRow>& rows,
               const std::string& name,
               std::int64_t max_lateness_ns,
               ImuCleaning& cleaning) {
  std::int64_t latest = std::numeric_limits<std::int64_t>::min();
  for (const ImuRow& row : rows) {
    const std::int64_t time_ns = row.sample.time_ns;
    if (time_ns < latest) {
      if (latest - time_ns > max_lateness_ns) {
        throw InputError(fmt::format(
            "{}:{}: stamp {} is {:.3f} s before an earlier line, at most {:.1f} s can be sorted; "
            "sort the file, or cut it where the clock was set back",
            name, row.line, time_ns, to_seconds(latest - time_ns), to_seconds(max_lateness_ns)));
      }
      ++cleaning.late;
    }
    latest = std::max(latest, time_ns);
  }
  if (cleaning.late == 0) return;
  std::stable_sort(rows.begin(), rows.end(), [](const ImuRow& a, const ImuRow& b) {
    return a.sample.time_ns < b.sample.time_ns;
  });
}

}  // namespace

CsvReader open_imu_csv(LineReader lines) {
  using Kind = CsvColumn::Kind;
  return {std::move(lines),
          {{"time [ns]", Kind::kTime},
           {"w_x [rad/s]", Kind::kReal},
           {"w_y [rad/s]", Kind::kReal},
           {"w_z [rad/s]", Kind::kReal},
           {"a_x [m/s^2]", Kind::kReal},
           {"a_y [m/s^2]", Kind::kReal},
           {"a_z [m/s^2]", Kind::kReal}}};
}

ImuRow imu_row(const CsvReader& csv) {
  ImuRow row;
  row.line = csv.line_number();
  row.sample.time_ns = csv.time_ns(0);
  row.sample.angular_velocity = {csv.real(1), csv.real(2), csv.real(3)};
  row.sample.linear_acceleration = {csv.real(4), csv.real(5), csv.real(6)};
  return row;
}

ImuTable clean_imu(std::vector<ImuRow> rows,
                   const std::string& name,
                   std::int64_t max_lateness_ns) {
  ImuTable table;
  drop_not_finite(rows, table.cleaning);
  sort_late(rows, name, max_lateness_ns, table.cleaning);
  table.samples.reserve(rows.size());
  for (const ImuRow& row : rows) {
    if (table.samples.empty() || table.samples.back().time_ns != row.sample.time_ns) {
      table.samples.push_back(row.sample);
    } else if (same_reading(table.samples.back(), row.sample)) {
      ++table.cleaning.repeated;
    } else {
      ++table.cleaning.conflicting;
    }
  }
  return table;
}

ImuTable read_imu_csv(const std::filesystem::path& file) {
  CsvReader csv = open_imu_csv(LineReader(file));
  std::vector<ImuRow> rows;
  while (csv.next()) rows.push_back(imu_row(csv));
  ImuTable table = clean_imu(std::move(rows), file.string());
  table.cleaning.cut_off = csv.cut_off();
  log_cleaning(file.string(), table.cleaning);
  return table;
}

void log_cleaning(const std::string& name, const ImuCleaning& cleaning) {
  if (cleaning.dropped() == 0 && cleaning.late == 0 && !cleaning.cut_off) return;
  log::warn(
      "{}: dropped {} samples that are not finite, {} repeated, {} with the stamp of another; "
      "sorted {} late ones{}",
      name, cleaning.not_finite, cleaning.repeated, cleaning.conflicting, cleaning.late,
      cleaning.cut_off ? "; the last line is cut off and was skipped" : "");
}

}  // namespace imslam::datasets
