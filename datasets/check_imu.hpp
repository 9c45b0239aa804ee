#pragma once

#include "datasets/finding.hpp"
#include "datasets/sequence.hpp"

namespace imslam::datasets {

/// Rates and gaps of frames and samples, their overlap in time, coverage by the truth.
void check_timing(const Sequence& sequence, Findings& findings);

/// Units (g, degrees), gravity, saturation, frozen axes.
void check_imu_values(const ImuData& imu, const std::string& file, Findings& findings);

}  // namespace imslam::datasets
