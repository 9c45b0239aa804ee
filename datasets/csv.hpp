#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/text_lines.hpp"

namespace imslam::datasets {

/// Stamps beyond +-4e18 ns (year 2096) are refused, so that differences never overflow.
inline constexpr std::int64_t kMaxTimeNs = 4'000'000'000'000'000'000;

struct CsvColumn {
  enum class Kind { kTime, kReal, kText };
  std::string name;  ///< for messages, e.g. "w_x [rad/s]"
  Kind kind = Kind::kReal;
};

/// Rows of comma-separated values with known leading columns.
///
/// Accepted: one header line in front (with or without #), # comments, empty lines, blanks around
/// values, one trailing comma, a last line that is cut off (skipped, see cut_off()); nan and inf
/// as values.
/// InputError(kData) "file:line:column: expected ..., found ...; remedy" otherwise: too few
/// columns, too many (unless `allow_more`), a value that is no number, a decimal comma.
/// After such an error next() may be called again: it goes on with the following line.
class CsvReader {
 public:
  CsvReader(LineReader lines, std::vector<CsvColumn> columns, bool allow_more = false);

  bool next();

  std::int64_t time_ns(std::size_t column) const { return times_.at(column); }
  double real(std::size_t column) const { return reals_.at(column); }
  std::string_view text(std::size_t column) const { return fields_.at(column); }

  std::size_t line_number() const { return lines_.number(); }
  std::string where() const { return lines_.where(); }
  bool cut_off() const { return cut_off_; }  ///< the file ended inside a row

 private:
  bool is_data();
  bool parse_row();  ///< false: a cut-off last row
  bool parse_field(std::size_t column);
  void check_column_count() const;
  [[noreturn]] void fail_field(std::size_t column) const;

  LineReader lines_;
  std::vector<CsvColumn> columns_;
  bool allow_more_;
  bool header_possible_ = true;
  bool cut_off_ = false;
  std::vector<std::string_view> fields_;
  std::vector<std::size_t> offsets_;  ///< of the fields in the line
  std::vector<std::int64_t> times_;
  std::vector<double> reals_;
};

}  // namespace imslam::datasets
