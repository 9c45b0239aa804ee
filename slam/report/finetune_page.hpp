#pragma once

#include <filesystem>
#include <string>

#include "slam/report/finetune_content.hpp"

namespace imslam::report {

/// Makes `folder`/report.html and `folder`/learning.svg of a finished fine-tuning. Throws
/// InputError if there is none (kData) or the folder cannot be written to (kOutput).
void write_finetune_report(const std::filesystem::path& folder);

/// The page: what became of the networks, before and after, the curves, whether loss and true
/// errors agree, the model cards. Loads nothing; links to the reports of the two runs.
std::string finetune_html(const FinetuneContent& content);

}  // namespace imslam::report
