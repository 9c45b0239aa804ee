#pragma once

#include <map>
#include <string>

#include "slam/evaluation/align.hpp"
#include "slam/evaluation/errors.hpp"

namespace imslam::evaluation {

/// The words of the command line for each choice, as evo and the documentation spell them.
const std::map<std::string, Relation>& relation_names();
const std::map<std::string, Alignment>& alignment_names();
const std::map<std::string, DeltaUnit>& delta_unit_names();

/// e.g. "translation part" and "m"; the unit is empty for figures without one.
std::string words_for(Relation relation);
std::string unit_of(Relation relation);

/// e.g. "delta = 1 (frames)", "delta = 1.0 (m)", as evo writes it.
std::string delta_text(const DeltaOptions& options);

/// evo's title, e.g. "APE w.r.t. translation part (m)\n(with SE(3) Umeyama alignment)".
/// `delta` = nullptr: an absolute error.
std::string evo_title(Relation relation,
                      const AlignmentOptions& alignment,
                      const DeltaOptions* delta,
                      const std::string& projection = "");

}  // namespace imslam::evaluation
