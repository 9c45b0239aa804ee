#pragma once

#include <functional>

#include "slam/base/process_group.hpp"

namespace imslam {

/// run_in_processes() where mpirun started this program. Built without MPI: InputError(kUsage).
ExitCode run_under_mpi(const std::function<ExitCode(ProcessGroup&)>& body);

}  // namespace imslam
