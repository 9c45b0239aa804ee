#pragma once

#include "datasets/finding.hpp"
#include "datasets/sequence.hpp"

namespace imslam::datasets {

/// Rates and gaps of frames and samples, their overlap in time, coverage by the truth.
/// `imu_file` is the csv of the samples, for lines; empty if they come from elsewhere.
void check_timing(const Sequence& sequence, const std::string& imu_file, Findings& findings);

/// Rate and gaps of the samples.
void check_samples(const ImuData& imu, const std::string& file, Findings& findings);

/// Units (g, degrees), gravity, saturation, impossible values, frozen axes.
void check_imu_values(const ImuData& imu, const std::string& file, Findings& findings);

}  // namespace imslam::datasets
