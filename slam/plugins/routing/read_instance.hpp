#pragma once

#include <filesystem>
#include <string>

#include "slam/plugins/routing/instance.hpp"

namespace imslam::routing {

/// Reads the cities of a file, whichever of these it is:
///
///   TSPLIB (has a line DIMENSION)   EDGE_WEIGHT_TYPE EUC_2D, CEIL_2D, GEO, ATT, or EXPLICIT with
///                                   EDGE_WEIGHT_FORMAT FULL_MATRIX, UPPER_ROW, LOWER_ROW,
///                                   UPPER_DIAG_ROW or LOWER_DIAG_ROW
///   coordinates                     a line "x,y" per city
///   table of distances              n lines of n numbers, n > 2; row: from, column: to
///
/// In tables numbers are separated by commas, semicolons or blanks; empty lines and those that
/// start with # are skipped, and one line of names may come first. The depot is city `depot`,
/// counted from 0. Throws InputError "file:line: ..." on anything else, NaN, negative distances or
/// a depot that is not there.
Instance read_instance(const std::filesystem::path& file, int depot);

/// The same from text; `name` stands in errors.
Instance parse_instance(const std::string& name, const std::string& text, int depot);

// The two kinds of text. `parse_table` decides between coordinates and distances by the shape.
Instance parse_tsplib(const std::string& name, const std::string& text);
Instance parse_table(const std::string& name, const std::string& text);

inline constexpr int kMostCities = 20000;

}  // namespace imslam::routing
