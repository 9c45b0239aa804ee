#pragma once

#include <filesystem>
#include <string>

#include "slam/report/run_content.hpp"

namespace imslam::report {

/// Makes `run_folder`/report.html and `run_folder`/trajectory.svg from what the folder holds.
/// Missing and damaged files become notes in the report. Throws InputError if the folder does not
/// exist (kData) or cannot be written to (kOutput).
///
/// The folder of a fine-tuning gets report.html and learning.svg: see finetune_page.hpp.
void write_report(const std::filesystem::path& run_folder);

/// The page: one file that loads nothing else, the same bytes for the same content. Its content
/// security policy names the hashes of its own script and style, so nothing else can run in it.
std::string report_html(const RunContent& run);

}  // namespace imslam::report
