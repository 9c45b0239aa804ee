#include "datasets/stamp_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/csv.hpp"
#include "datasets/image_index.hpp"
#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/base/text.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

bool all_digits(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// "4070504" after the decimal point: 407050400 ns; digits beyond the ninth are dropped.
std::int64_t fraction_ns(std::string_view digits) {
  std::int64_t ns = 0;
  for (std::size_t i = 0; i < 9; ++i) ns = ns * 10 + (i < digits.size() ? digits[i] - '0' : 0);
  return ns;
}

/// Days from 1970-01-01 to a date of the Gregorian calendar (Hinnant, "chrono-compatible
/// low-level date algorithms").
std::int64_t days_from_epoch(std::int64_t year, std::int64_t month, std::int64_t day) {
  year -= month <= 2 ? 1 : 0;
  const std::int64_t era = year / 400;
  const std::int64_t year_of_era = year - era * 400;
  const std::int64_t day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  return era * 146097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year -
         719468;
}

/// Parts of "2011-10-03" or "12:55:34" as numbers within bounds; false if they are not.
bool parse_parts(std::string_view text,
                 char separator,
                 const std::int64_t (&high)[3],
                 std::int64_t (&parts)[3]) {
  const auto words = split(text, separator);
  if (words.size() != 3) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = all_digits(words[i]) ? parse_int64(words[i]) : std::nullopt;
    if (!value || *value > high[i]) return false;
    parts[i] = *value;
  }
  return true;
}

}  // namespace

std::optional<std::int64_t> parse_seconds(std::string_view text) {
  text = trim(text);
  const bool negative = !text.empty() && text.front() == '-';
  const std::string_view digits = negative ? text.substr(1) : text;
  const auto point = digits.find('.');
  const std::string_view whole = digits.substr(0, point);
  const std::string_view fraction =
      point == std::string_view::npos ? std::string_view() : digits.substr(point + 1);
  const bool plain = all_digits(whole) && (fraction.empty() || all_digits(fraction));
  if (plain && whole.size() <= 10) {
    const std::int64_t seconds = parse_int64(whole).value_or(0);
    if (seconds > kMaxTimeNs / kNsPerSecond) return std::nullopt;
    const std::int64_t ns = seconds * kNsPerSecond + fraction_ns(fraction);
    if (ns > kMaxTimeNs) return std::nullopt;
    return negative ? -ns : ns;
  }
  const auto seconds = parse_double(text);
  if (!seconds || !(std::abs(*seconds) < to_seconds(kMaxTimeNs))) return std::nullopt;
  return to_nanoseconds(*seconds);
}

std::optional<std::int64_t> parse_date_time(std::string_view text) {
  const auto words = split_blanks(text);
  if (words.size() != 2) return std::nullopt;
  std::int64_t date[3] = {};
  std::int64_t clock[3] = {};
  const auto point = words[1].find('.');
  const std::string_view fraction =
      point == std::string_view::npos ? std::string_view() : words[1].substr(point + 1);
  if (!parse_parts(words[0], '-', {2090, 12, 31}, date) || date[0] < 1970 || date[1] < 1 ||
      date[2] < 1 || !parse_parts(words[1].substr(0, point), ':', {23, 59, 60}, clock) ||
      (!fraction.empty() && !all_digits(fraction))) {
    return std::nullopt;
  }
  const std::int64_t seconds = days_from_epoch(date[0], date[1], date[2]) * 86400 +
                               clock[0] * 3600 + clock[1] * 60 + clock[2];
  return seconds * kNsPerSecond + fraction_ns(fraction);
}

std::vector<std::int64_t> read_times_file(const std::filesystem::path& file) {
  LineReader lines(file);
  std::vector<std::int64_t> times;
  std::int64_t latest = std::numeric_limits<std::int64_t>::min();
  std::size_t late = 0;
  while (lines.next()) {
    const std::string_view line = trim(lines.line());
    if (line.empty() || line.front() == '#') continue;
    const auto time_ns = parse_seconds(line);
    if (!time_ns) {
      throw InputError(lines.where(1) + ": expected one stamp in seconds; correct the line");
    }
    if (!times.empty() && *time_ns < latest) {
      if (latest - *time_ns > kMaxImageLatenessNs) {
        throw InputError(
            fmt::format("{}: stamp is {:.3f} s before an earlier line; line i must "
                        "hold the time of image i, in seconds",
                        lines.where(1), to_seconds(latest - *time_ns)));
      }
      ++late;
    }
    latest = std::max(latest, *time_ns);
    times.push_back(*time_ns);
  }
  std::sort(times.begin(), times.end());
  if (late > 0) log::warn("{}: sorted {} late stamps", file.string(), late);
  if (std::adjacent_find(times.begin(), times.end()) != times.end()) {
    throw InputError(file.string() +
                     ": two images have the same stamp; line i must hold the time "
                     "of image i, in seconds");
  }
  return times;
}

std::vector<std::optional<std::int64_t>> read_timestamps_file(const std::filesystem::path& file) {
  LineReader lines(file);
  std::vector<std::optional<std::int64_t>> times;
  while (lines.next()) {
    const std::string_view line = trim(lines.line());
    times.push_back(line.empty() ? std::nullopt : parse_date_time(line));
    if (!line.empty() && !times.back()) {
      throw InputError(lines.where(1) +
                       ": expected a stamp like 2011-10-03 12:55:34.997992704; correct the line");
    }
  }
  return times;
}

}  // namespace imslam::datasets
