#include "slam/base/forked_group.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

#include "slam/base/log.hpp"
#include "slam/base/packed_strings.hpp"

namespace imslam {
namespace {

constexpr int kPoll_ms = 100;
constexpr int kMostJobs = 1024;

[[noreturn]] void fail(const std::string& what) { throw InputError(what, ExitCode::kResource); }

/// Owns one end of a pair of sockets that carries messages: a length, then as many bytes.
class Channel {
 public:
  explicit Channel(int descriptor) : descriptor_(descriptor) {}
  ~Channel() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Channel(Channel&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Channel& operator=(Channel&&) = delete;

  /// False: the other end has gone.
  bool send(const std::string& message) const {
    return write_all(length_bytes(message.size())) && write_all(message);
  }

  /// Waits, asking `wait` every 100 ms. False: the other end has gone.
  bool receive(std::string& message, const std::function<void()>& wait) const {
    std::string length(kLengthBytes, '\0');
    if (!read_all(length, wait)) return false;
    message.resize(length_of(length.data()));
    return read_all(message, wait);
  }

 private:
  bool write_all(const std::string& bytes) const {
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t done = ::send(descriptor_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) return false;
      at += static_cast<std::size_t>(done);
    }
    return true;
  }

  bool read_all(std::string& bytes, const std::function<void()>& wait) const {
    for (std::size_t at = 0; at < bytes.size();) {
      pollfd ready{descriptor_, POLLIN, 0};
      if (::poll(&ready, 1, kPoll_ms) <= 0) {
        wait();
        continue;
      }
      const ssize_t done = ::read(descriptor_, bytes.data() + at, bytes.size() - at);
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) return false;
      at += static_cast<std::size_t>(done);
    }
    return true;
  }

  int descriptor_;
};

/// What a forked rank sees: only rank 0.
class ForkedRank : public ProcessGroup {
 public:
  ForkedRank(int rank, int size, Channel parent)
      : rank_(rank), size_(size), parent_(std::move(parent)) {}

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  std::vector<std::string> gather(const std::string& bytes) override {
    if (!parent_.send(bytes)) fail("the first process has gone");
    return {};
  }
  std::string broadcast(const std::string& /*bytes*/) override {
    std::string message;
    if (!parent_.receive(message, [] {})) fail("the first process has gone");
    return message;
  }

 private:
  int rank_;
  int size_;
  Channel parent_;
};

struct Child {
  pid_t pid = -1;
  Channel channel;
};

std::string ending(int status) {
  if (WIFSIGNALED(status)) return fmt::format("signal {}", WTERMSIG(status));
  return fmt::format("exit code {}", WEXITSTATUS(status));
}

/// Rank 0; its children end with it.
class ForkingRank : public ProcessGroup {
 public:
  explicit ForkingRank(const ProcessOptions& options) : options_(options) {}
  ~ForkingRank() override {
    terminate();
    for (const Child& child : children_) {
      if (child.pid > 0) ::waitpid(child.pid, nullptr, 0);
    }
  }
  ForkingRank(const ForkingRank&) = delete;
  ForkingRank& operator=(const ForkingRank&) = delete;

  void add(Child child) { children_.push_back(std::move(child)); }

  int rank() const override { return 0; }
  int size() const override { return options_.jobs; }

  std::vector<std::string> gather(const std::string& bytes) override {
    std::vector<std::string> all = {bytes};
    for (Child& child : children_) {
      all.emplace_back();
      if (!child.channel.receive(all.back(), [this] { pass_stop_on(); })) report_loss(child);
    }
    return all;
  }

  std::string broadcast(const std::string& bytes) override {
    for (Child& child : children_) {
      if (!child.channel.send(bytes)) report_loss(child);
    }
    return bytes;
  }

  /// After the body: the children have nothing more to say.
  void wait_for_all() {
    for (Child& child : children_) {
      int status = 0;
      if (::waitpid(std::exchange(child.pid, -1), &status, 0) > 0 && status != 0) {
        log::warn("a process ended with {} after its work was done", ending(status));
      }
    }
  }

  void close_channels_in_child() { children_.clear(); }

 private:
  void pass_stop_on() {
    if (!options_.stopped || !options_.stopped() || std::exchange(passed_on_, true)) return;
    terminate();
  }
  void terminate() const {
    for (const Child& child : children_) {
      if (child.pid > 0) ::kill(child.pid, SIGTERM);
    }
  }
  [[noreturn]] void report_loss(Child& child) const {
    const auto rank = 1 + (&child - children_.data());
    int status = 0;
    ::waitpid(std::exchange(child.pid, -1), &status, 0);
    const auto what = fmt::format("process {} of {} ended early with {}; what was finished is kept",
                                  rank + 1, options_.jobs, ending(status));
    const bool told = WIFEXITED(status) && WEXITSTATUS(status) != 0;
    throw InputError(what, told ? static_cast<ExitCode>(WEXITSTATUS(status)) : ExitCode::kResource);
  }

  const ProcessOptions& options_;
  std::vector<Child> children_;
  bool passed_on_ = false;
};

/// The whole life of a child after the fork.
[[noreturn]] void live_as_child(int rank,
                                const ProcessOptions& options,
                                Channel channel,
                                const std::function<ExitCode(ProcessGroup&)>& body) {
  ExitCode code = ExitCode::kInternal;
  try {
    ForkedRank group(rank, options.jobs, std::move(channel));
    body(group);
    code = ExitCode::kOk;
  } catch (const InputError& error) {
    log::error("{}", error.what());
    code = error.code();
  } catch (const std::exception& error) {
    log::error("{}", error.what());
  }
  std::fflush(nullptr);
  ::_exit(static_cast<int>(code));
}

}  // namespace

ExitCode run_forked(const ProcessOptions& options,
                    const std::function<ExitCode(ProcessGroup&)>& body) {
  if (options.jobs > kMostJobs) {
    throw InputError(fmt::format("--jobs: at most {}", kMostJobs), ExitCode::kUsage);
  }
  ForkingRank group(options);
  const pid_t parent = ::getpid();
  std::fflush(nullptr);  // what is buffered would come out once per process
  for (int rank = 1; rank < options.jobs; ++rank) {
    int ends[2] = {-1, -1};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
      fail(fmt::format("no socket for process {} ({})", rank + 1, std::strerror(errno)));
    }
    Channel ours(ends[0]);
    Channel theirs(ends[1]);
    const pid_t pid = ::fork();
    if (pid < 0) fail(fmt::format("process {} cannot start ({})", rank + 1, std::strerror(errno)));
    if (pid > 0) {
      group.add({pid, std::move(ours)});
      continue;
    }
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(static_cast<int>(ExitCode::kResource));
    // Ends of others that stayed open here would hide that one of them has gone.
    group.close_channels_in_child();
    { const Channel closed = std::move(ours); }
    live_as_child(rank, options, std::move(theirs), body);
  }
  const ExitCode code = body(group);
  group.wait_for_all();
  return code;
}

}  // namespace imslam
