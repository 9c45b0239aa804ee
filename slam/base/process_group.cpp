#include "slam/base/process_group.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "slam/base/forked_group.hpp"
#include "slam/base/mpi_group.hpp"
#include "slam/base/packed_strings.hpp"
#include "slam/base/text.hpp"

namespace imslam {
namespace {

class SingleProcess : public ProcessGroup {
 public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  std::vector<std::string> gather(const std::string& bytes) override { return {bytes}; }
  std::string broadcast(const std::string& bytes) override { return bytes; }
};

std::string bytes_of(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::vector<float> floats_of(const std::string& bytes) {
  std::vector<float> values(bytes.size() / sizeof(float));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

/// A positive number of the environment, else 0.
int environment_number(const char* name) {
  const char* text = std::getenv(name);
  const auto number = text == nullptr ? std::nullopt : parse_int64(text);
  return number && *number > 0 && *number < (1 << 20) ? static_cast<int>(*number) : 0;
}

/// Open MPI and the launchers of MPICH, Intel MPI and Slurm's PMI say so here.
bool started_by_mpirun() {
  return environment_number("OMPI_COMM_WORLD_SIZE") > 0 || environment_number("PMI_SIZE") > 0;
}

}  // namespace

void ProcessGroup::barrier() {
  gather("");
  broadcast("");
}

bool ProcessGroup::any(bool own) {
  const auto all = gather(own ? "1" : "0");
  return broadcast(std::count(all.begin(), all.end(), "1") > 0 ? "1" : "0") == "1";
}

std::unique_ptr<ProcessGroup> single_process() { return std::make_unique<SingleProcess>(); }

std::vector<std::string> gather_items(ProcessGroup& group,
                                      std::size_t count,
                                      const std::function<std::string(std::size_t)>& item) {
  std::vector<std::string> mine;
  for (std::size_t i = 0; i < count; ++i) {
    if (group.owns(i)) mine.push_back(item(i));
  }
  std::vector<std::vector<std::string>> shares;
  for (const std::string& packed : group.gather(pack_strings(mine))) {
    shares.push_back(unpack_strings(packed));
  }
  if (group.rank() != 0) return {};
  const auto size = static_cast<std::size_t>(group.size());
  std::vector<std::string> all;
  for (std::size_t i = 0; i < count; ++i)
    all.push_back(std::move(shares.at(i % size).at(i / size)));
  return all;
}

std::vector<float> ordered_sum(ProcessGroup& group,
                               std::size_t count,
                               std::size_t length,
                               const std::function<std::vector<float>(std::size_t)>& contribution) {
  const auto packed = gather_items(group, count, [&](std::size_t i) {
    const std::vector<float> values = contribution(i);
    expects(values.size() == length, "ordered_sum: every contribution has `length` values");
    return bytes_of(values);
  });
  std::vector<float> sum(length, 0.0F);
  for (const std::string& bytes : packed) {
    const std::vector<float> values = floats_of(bytes);
    for (std::size_t k = 0; k < length; ++k) sum[k] += values[k];
  }
  return floats_of(group.broadcast(bytes_of(sum)));
}

ExitCode run_in_processes(const ProcessOptions& options,
                          const std::function<ExitCode(ProcessGroup&)>& body) {
  if (options.jobs < 1) throw InputError("--jobs must be 1 or more", ExitCode::kUsage);
  if (started_by_mpirun()) {
    if (options.jobs > 1) {
      throw InputError("--jobs does not go with mpirun, which says by itself how many processes",
                       ExitCode::kUsage);
    }
    return run_under_mpi(body);
  }
  if (options.jobs > 1) return run_forked(options, body);
  return body(*single_process());
}

int processes_on_this_machine(const ProcessOptions& options) {
  if (!started_by_mpirun()) return options.jobs;
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"}) {
    if (const int count = environment_number(name)) return count;
  }
  return 1;
}

}  // namespace imslam
