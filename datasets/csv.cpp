#include "datasets/csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "slam/base/text.hpp"

namespace imslam::datasets {
namespace {

std::string names(const std::vector<CsvColumn>& columns) {
  std::string text;
  for (const CsvColumn& column : columns) text += (text.empty() ? "" : ", ") + column.name;
  return text;
}

/// Input may be anything: shown shortened and without control characters.
std::string printable(std::string_view text) {
  std::string shown;
  for (const char c : text.substr(0, 40)) {
    shown += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  }
  return text.size() > 40 ? shown + "..." : shown;
}

bool looks_like_header(std::string_view first_field) {
  return !first_field.empty() && !parse_double(first_field) &&
         (std::isalpha(static_cast<unsigned char>(first_field.front())) != 0 ||
          first_field.front() == '"');
}

}  // namespace

CsvReader::CsvReader(LineReader lines, std::vector<CsvColumn> columns, bool allow_more)
    : lines_(std::move(lines)),
      columns_(std::move(columns)),
      allow_more_(allow_more),
      times_(columns_.size()),
      reals_(columns_.size()) {}

bool CsvReader::next() {
  while (lines_.next()) {
    if (is_data()) return parse_row();
  }
  return false;
}

bool CsvReader::is_data() {
  const std::string_view line = trim(lines_.line());
  if (line.empty() || line.front() == '#') return false;
  fields_ = split(lines_.line(), ',');
  offsets_.clear();
  for (std::string_view& field : fields_) {
    const auto blanks = std::min(field.find_first_not_of(" \t"), field.size());
    offsets_.push_back(static_cast<std::size_t>(field.data() - lines_.line().data()) + blanks);
    field = trim(field);
  }
  const bool header = header_possible_ && looks_like_header(fields_.front());
  header_possible_ = false;
  return !header;
}

bool CsvReader::parse_row() {
  if (fields_.size() > 1 && fields_.back().empty() && fields_.size() > columns_.size()) {
    fields_.pop_back();  // a trailing comma
  }
  const bool cut = !lines_.terminated();
  if (cut && fields_.size() < columns_.size()) {
    cut_off_ = true;
    return false;
  }
  check_column_count();
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (parse_field(i)) continue;
    if (cut && i + 1 == fields_.size()) {
      cut_off_ = true;
      return false;
    }
    fail_field(i);
  }
  return true;
}

bool CsvReader::parse_field(std::size_t column) {
  switch (columns_[column].kind) {
    case CsvColumn::Kind::kTime: {
      const auto value = parse_int64(fields_[column]);
      if (!value || *value > kMaxTimeNs || *value < -kMaxTimeNs) return false;
      times_[column] = *value;
      return true;
    }
    case CsvColumn::Kind::kReal: {
      const auto value = parse_double(fields_[column]);
      if (!value) return false;
      reals_[column] = *value;
      return true;
    }
    case CsvColumn::Kind::kText:
      break;
  }
  return !fields_[column].empty();
}

void CsvReader::check_column_count() const {
  const std::size_t found = fields_.size();
  if (found == columns_.size() || (allow_more_ && found > columns_.size())) return;
  std::string remedy = "complete or remove the line";
  const std::string_view line = lines_.line();
  if (line.find(';') != std::string_view::npos) {
    remedy = "separate values by commas, with a point as decimal sign";
  } else if (found > columns_.size()) {
    remedy = "write a point, not a comma, as decimal sign, and remove extra columns";
  } else if (found == 1 && split_blanks(line).size() >= columns_.size()) {
    remedy = "separate values by commas, not blanks";
  }
  throw InputError(fmt::format("{}: expected {} columns ({}), found {}; {}", lines_.where(1),
                               columns_.size(), names(columns_), found, remedy));
}

void CsvReader::fail_field(std::size_t column) const {
  if (lines_.line().find(';') != std::string_view::npos) {
    throw InputError(lines_.where(1) +
                     ": expected commas between the columns, found semicolons; "
                     "write 1,0.5 for 1;0,5");
  }
  const bool is_time = columns_[column].kind == CsvColumn::Kind::kTime;
  throw InputError(fmt::format("{}: expected {} as {}, found \"{}\"; correct or remove the line",
                               lines_.where(offsets_[column] + 1), columns_[column].name,
                               is_time ? "a whole number of nanoseconds" : "a number",
                               printable(fields_[column])));
}

}  // namespace imslam::datasets
