#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/csv.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::datasets {

/// A sample and the line that it stands on.
struct ImuRow {
  std::size_t line = 0;
  ImuSample sample;
};

/// What had to be done to make the samples strictly increasing and finite.
struct ImuCleaning {
  std::size_t not_finite = 0;   ///< dropped: a value is nan or inf
  std::size_t repeated = 0;     ///< dropped: an exact copy
  std::size_t conflicting = 0;  ///< dropped: the stamp of another sample; the first one is kept
  std::size_t late = 0;         ///< moved to their place
  bool cut_off = false;         ///< the file ended inside a row, which was skipped

  std::size_t dropped() const { return not_finite + repeated + conflicting; }
};

struct ImuTable {
  std::vector<ImuSample> samples;  ///< strictly increasing stamps, all finite
  ImuCleaning cleaning;
};

/// Samples that arrive at most this late are sorted in; later ones are an error.
inline constexpr std::int64_t kMaxImuLatenessNs = 100'000'000;

/// Opens an IMU csv: time_ns, w_x, w_y, w_z [rad/s], a_x, a_y, a_z [m/s^2] (EuRoC column order).
CsvReader open_imu_csv(LineReader lines);
ImuRow imu_row(const CsvReader& csv);

/// Sorts, drops what is not finite or repeated. The result equals that of the clean recording.
/// InputError(kData) "name:line: ..." if a sample is later than `max_lateness_ns`.
ImuTable clean_imu(std::vector<ImuRow> rows,
                   const std::string& name,
                   std::int64_t max_lateness_ns = kMaxImuLatenessNs);

/// Reads and cleans a whole file; one warning in the log if anything had to be done.
/// InputError(kData) as CsvReader and clean_imu.
ImuTable read_imu_csv(const std::filesystem::path& file);

/// The one warning about a cleaned file; silent if nothing had to be done.
void log_cleaning(const std::string& name, const ImuCleaning& cleaning);

}  // namespace imslam::datasets
