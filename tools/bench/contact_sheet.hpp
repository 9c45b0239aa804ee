#pragma once

#include <string>
#include <vector>

#include "slam/training/triplet.hpp"

namespace imslam::bench {

/// One row per triplet: left0, right0, left1, disparity (bright = near), flow (hue = direction),
/// match states (of the disparity in red, of the flow in green; black: visible). Throws InputError
/// if the file cannot be written.
void write_contact_sheet(const std::vector<training::Triplet>& triplets, const std::string& file);

}  // namespace imslam::bench
