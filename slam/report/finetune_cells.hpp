#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "slam/report/finetune_content.hpp"

namespace imslam::report {

/// The member of that name, or an empty object.
const nlohmann::json& at(const nlohmann::json& object, const char* key);

/// Four digits; a dash for what is not a number.
std::string number_text(double value);

/// How a measure went from before to after, for a table.
struct Change {
  std::string text;
  const char* kind = "same";  ///< good, bad or same: classes of the template
};

/// All measures are errors or losses: less is better. The zero of a loss means nothing.
Change change_of(const Measure& measure, double before, double after);

}  // namespace imslam::report
