#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "slam/base/error.hpp"

namespace imslam {

/// Processes that run the same program and share its work out among themselves: started by mpirun,
/// forked on this machine, or one alone.
///
/// Work item i belongs to rank i % size. Every member function but rank(), size(), owns() is
/// collective: all ranks call the same ones in the same order. What comes out never depends on the
/// number of ranks as long as the items are brought back into their order: see gather_items() and
/// ordered_sum(). Throws InputError(kResource) if another process has gone.
class ProcessGroup {
 public:
  virtual ~ProcessGroup() = default;

  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Rank 0 gets what every rank gave, by rank; the others get nothing. Any bytes, any length.
  virtual std::vector<std::string> gather(const std::string& bytes) = 0;

  /// All ranks get what rank 0 gave.
  virtual std::string broadcast(const std::string& bytes) = 0;

  /// Returns when all ranks have come here.
  void barrier();

  /// Whether any rank says so: the same on all of them.
  bool any(bool own);

  bool owns(std::size_t item) const {
    return item % static_cast<std::size_t>(size()) == static_cast<std::size_t>(rank());
  }
};

/// A group of one.
std::unique_ptr<ProcessGroup> single_process();

/// Computes item(i) for i in [0, count), each on its owner; rank 0 gets all of them in order,
/// the others nothing.
std::vector<std::string> gather_items(ProcessGroup& group,
                                      std::size_t count,
                                      const std::function<std::string(std::size_t)>& item);

/// sum_i contribution(i) over i in [0, count), each computed on its owner, added in the order of i:
/// the same floats on every rank for any number of ranks.
///
/// contribution(i) has `length` values; ContractError otherwise.
std::vector<float> ordered_sum(ProcessGroup& group,
                               std::size_t count,
                               std::size_t length,
                               const std::function<std::vector<float>(std::size_t)>& contribution);

/// How many processes, and when they are to stop.
struct ProcessOptions {
  int jobs = 1;                   ///< on this machine; mpirun decides by itself
  std::function<bool()> stopped;  ///< true: rank 0 passes SIGTERM on to those that it has forked
};

/// Runs `body` once per process of the group: those of mpirun where it started this program, else
/// `jobs` of this machine, forked here and ended when body returns. To be called before the process
/// has threads. Returns what body returned on rank 0 (kOk on the other ranks of mpirun); on a
/// forked rank an exception of body is logged and ends that process with its exit code, which rank
/// 0 reports.
///
/// Throws InputError(kUsage) for jobs < 1, for mpirun together with jobs > 1, and if mpirun started
/// a program built without MPI; InputError(kResource) if no process can be made.
ExitCode run_in_processes(const ProcessOptions& options,
                          const std::function<ExitCode(ProcessGroup&)>& body);

/// How many processes of the group share this machine with this one, it included.
int processes_on_this_machine(const ProcessOptions& options);

/// Whether this program can be started by mpirun.
bool built_with_mpi();

}  // namespace imslam
