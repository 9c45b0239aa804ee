#pragma once

#include <functional>

#include "slam/base/process_group.hpp"

namespace imslam {

/// run_in_processes() with options.jobs > 1 on this machine: rank 0 is this process, the others are
/// its children, each tied to it by a pair of sockets. A child ends with its parent.
ExitCode run_forked(const ProcessOptions& options,
                    const std::function<ExitCode(ProcessGroup&)>& body);

}  // namespace imslam
