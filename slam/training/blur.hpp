#pragma once

#include <vector>

#include "slam/training/degradation.hpp"

namespace imslam::training {

/// Longest smear [px]; longer ones are cut.
constexpr int kLongestSmear = 48;

/// Both repeat the border outwards and keep the range of the values.
void blur_motion(const MotionBlur& blur, int width, int height, std::vector<float>& grey);
void blur_defocus(const DefocusBlur& blur, int width, int height, std::vector<float>& grey);

}  // namespace imslam::training
