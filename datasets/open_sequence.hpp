#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "datasets/sequence.hpp"

namespace imslam::datasets {

/// Opens a folder of any known format; the only switch over formats.
///
/// `format` = "auto" looks at what is in the folder; else one of sequence_formats().
/// Throws InputError(kData) if nothing fits, listing what was looked for, and
/// InputError(kCalibration) if the calibration is missing or impossible.
std::unique_ptr<Sequence> open_sequence(const std::filesystem::path& folder,
                                        const std::string& format = "auto");

std::vector<std::string> sequence_formats();

}  // namespace imslam::datasets
