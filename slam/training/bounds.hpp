#pragma once

#include "slam/learner/bounds.hpp"

namespace imslam::training {

using learner::require_within;

}  // namespace imslam::training
