#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

namespace imslam::datasets {

/// Decimal seconds ("1317384506.407050", "1.03844e-01") to nanoseconds; exact to the nanosecond
/// for plain decimals, which doubles would round to 240 ns. Empty if it is no such number.
std::optional<std::int64_t> parse_seconds(std::string_view text);

/// "2011-10-03 12:55:34.997992704" (UTC) to nanoseconds since 1970; empty if it is no date.
std::optional<std::int64_t> parse_date_time(std::string_view text);

/// KITTI odometry's times.txt: one stamp in seconds per line; empty lines are skipped. Images are
/// numbered as they were taken, so stamps out of order (at most kMaxImageLatenessNs) are sorted.
/// InputError(kData) "file:line: ..." for anything else, and for repeated stamps.
std::vector<std::int64_t> read_times_file(const std::filesystem::path& file);

/// KITTI raw's timestamps.txt: line i belongs to file i; an empty line (they occur) means that
/// there is no stamp for it.
std::vector<std::optional<std::int64_t>> read_timestamps_file(const std::filesystem::path& file);

}  // namespace imslam::datasets
