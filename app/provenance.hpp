#pragma once

#include "app/command.hpp"
#include "app/settings.hpp"
#include "datasets/sequence.hpp"
#include "slam/system/run_recorder.hpp"

namespace imslam::app {

/// What the manifest of a run says about how it came about.
system::RunProvenance provenance_of(const Settings& settings,
                                    const datasets::Sequence& sequence,
                                    const CommonOptions& common);

}  // namespace imslam::app
