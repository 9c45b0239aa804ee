#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imslam {

/// Parses the whole of `text` as a number: locale-proof, no trailing rest, surrounding blanks
/// allowed. Accepts nan and inf (callers decide). Empty if it is not a number.
std::optional<double> parse_double(std::string_view text);
std::optional<std::int64_t> parse_int64(std::string_view text);

std::string_view trim(std::string_view text);

/// Splits at every `separator`; "a,,b" gives three parts.
std::vector<std::string_view> split(std::string_view text, char separator);

/// Splits at runs of blanks and tabs; no empty parts.
std::vector<std::string_view> split_blanks(std::string_view text);

/// The candidate with the smallest edit distance to `word`, for "did you mean ...?".
/// Empty if none is closer than half of the word.
std::optional<std::string> nearest_name(std::string_view word,
                                        const std::vector<std::string>& candidates);

/// `text` as one field of a csv file: in quotes where it must be.
std::string csv_field(const std::string& text);

/// `text` as itself in LaTeX: %, &, _, #, $, {, }, ~, ^ and backslashes are escaped.
std::string latex_text(const std::string& text);

}  // namespace imslam
