#pragma once

#include <string>

#include "slam/report/finetune_content.hpp"

namespace imslam::report {

/// A drawing of a fine-tuning, with its own style (light and dark): the self-supervised losses over
/// the epochs on the left, the true errors against those of the given networks [%] on the right
/// (left out without truth). Empty string with fewer than two epochs.
std::string learning_svg(const FinetuneContent& content);

}  // namespace imslam::report
