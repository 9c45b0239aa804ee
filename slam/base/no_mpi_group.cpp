#include "slam/base/mpi_group.hpp"

namespace imslam {

ExitCode run_under_mpi(const std::function<ExitCode(ProcessGroup&)>& /*body*/) {
  throw InputError(
      "started by mpirun, but built without MPI; install libopenmpi-dev and build anew, or use "
      "--jobs on one machine",
      ExitCode::kUsage);
}

bool built_with_mpi() { return false; }

}  // namespace imslam
