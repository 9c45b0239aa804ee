#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include "slam/base/mpi_group.hpp"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>

namespace imslam {
namespace {

/// MPI counts bytes in int.
constexpr std::size_t kMostBytes = std::size_t{1} << 30U;
constexpr int kTag = 0;

void check(int code, const char* what) {
  if (code != MPI_SUCCESS) throw InputError(what, ExitCode::kResource);
}

/// MPI would wait at full speed for minutes on a processor that another rank could use.
void wait_for(MPI_Request request) {
  std::chrono::microseconds pause(20);
  constexpr std::chrono::microseconds kLongestPause(5000);
  int done = 0;
  while (true) {
    check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test failed");
    if (done != 0) return;
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, kLongestPause);
  }
}

void broadcast_block(void* data, int count, MPI_Datatype type) {
  MPI_Request request = MPI_REQUEST_NULL;
  check(MPI_Ibcast(data, count, type, 0, MPI_COMM_WORLD, &request), "MPI_Ibcast failed");
  wait_for(request);
}

void receive_block(void* data, int count, MPI_Datatype type, int source) {
  MPI_Request request = MPI_REQUEST_NULL;
  check(MPI_Irecv(data, count, type, source, kTag, MPI_COMM_WORLD, &request), "MPI_Irecv failed");
  wait_for(request);
}

void send_block(const void* data, int count, MPI_Datatype type) {
  MPI_Request request = MPI_REQUEST_NULL;
  check(MPI_Isend(data, count, type, 0, kTag, MPI_COMM_WORLD, &request), "MPI_Isend failed");
  wait_for(request);
}

class MpiGroup : public ProcessGroup {
 public:
  MpiGroup() {
    check(MPI_Comm_rank(MPI_COMM_WORLD, &rank_), "MPI gives no rank");
    check(MPI_Comm_size(MPI_COMM_WORLD, &size_), "MPI gives no size");
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  std::vector<std::string> gather(const std::string& bytes) override {
    if (rank_ != 0) {
      send(bytes);
      return {};
    }
    std::vector<std::string> all = {bytes};
    for (int source = 1; source < size_; ++source) all.push_back(receive(source));
    return all;
  }

  std::string broadcast(const std::string& bytes) override {
    std::uint64_t length = bytes.size();
    broadcast_block(&length, 1, MPI_UINT64_T);
    std::string message = bytes;
    message.resize(length);
    for (std::size_t at = 0; at < message.size(); at += kMostBytes) {
      broadcast_block(message.data() + at, block(message, at), MPI_BYTE);
    }
    return message;
  }

 private:
  static int block(const std::string& bytes, std::size_t at) {
    return static_cast<int>(std::min(kMostBytes, bytes.size() - at));
  }

  static void send(const std::string& bytes) {
    const std::uint64_t length = bytes.size();
    send_block(&length, 1, MPI_UINT64_T);
    for (std::size_t at = 0; at < bytes.size(); at += kMostBytes) {
      send_block(bytes.data() + at, block(bytes, at), MPI_BYTE);
    }
  }

  static std::string receive(int source) {
    std::uint64_t length = 0;
    receive_block(&length, 1, MPI_UINT64_T, source);
    std::string bytes(length, '\0');
    for (std::size_t at = 0; at < bytes.size(); at += kMostBytes) {
      receive_block(bytes.data() + at, block(bytes, at), MPI_BYTE, source);
    }
    return bytes;
  }

  int rank_ = 0;
  int size_ = 1;
};

}  // namespace

ExitCode run_under_mpi(const std::function<ExitCode(ProcessGroup&)>& body) {
  check(MPI_Init(nullptr, nullptr), "MPI_Init failed");
  // An exception leaves without MPI_Finalize: mpirun then ends the other ranks, which would wait.
  MpiGroup group;
  const ExitCode code = body(group);
  group.barrier();
  MPI_Finalize();
  return group.rank() == 0 ? code : ExitCode::kOk;
}

bool built_with_mpi() { return true; }

}  // namespace imslam
