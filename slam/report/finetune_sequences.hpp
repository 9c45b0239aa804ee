#pragma once

#include <string>

#include "slam/report/finetune_content.hpp"

namespace imslam::report {

/// Before and after, sequence by sequence, as HTML; empty for one sequence.
std::string sequences_table(const FinetuneContent& content);

/// What is taken for true of each device before and after, as HTML.
std::string device_table(const FinetuneContent& content);

}  // namespace imslam::report
