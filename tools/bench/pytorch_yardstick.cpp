#include "tools/bench/pytorch_yardstick.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <sstream>
#include <stdexcept>

#include "slam/base/error.hpp"

extern char** environ;

namespace imslam::bench {
namespace {

constexpr const char* kScript = IMSLAM_PYTORCH_SCRIPT;

std::string pass_name(Pass pass) {
  constexpr const char* kNames[] = {"forward", "backward_data", "backward_weights"};
  return kNames[static_cast<int>(pass)];
}

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2] = {};
    expects(::pipe(ends) == 0, "PyTorchYardstick: no pipe");
    read = ends[0];
    write = ends[1];
  }
};

}  // namespace

PyTorchYardstick::PyTorchYardstick(const std::string& python) {
  std::signal(SIGPIPE, SIG_IGN);  // a process that has ended is said so by its missing answer
  why_not_ = python.empty() ? "not wanted" : start(python);
}

std::string PyTorchYardstick::start(const std::string& python) {
  const Pipe in, out;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in.read, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out.write, STDOUT_FILENO);
  for (const int end : {in.read, in.write, out.read, out.write}) {
    posix_spawn_file_actions_addclose(&actions, end);
  }
  std::string words[] = {python, kScript};
  char* const arguments[] = {words[0].data(), words[1].data(), nullptr};
  const int error = posix_spawnp(&process_, python.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(in.read);
  ::close(out.write);
  requests_ = ::fdopen(in.write, "w");
  answers_ = ::fdopen(out.read, "r");
  if (error != 0) process_ = 0;
  if (error != 0) return "there is no program '" + python + "'";
  try {
    set_threads(1);
  } catch (const InputError&) {
    stop();
    return "'" + python + "' has no PyTorch (Debian: python3-torch for /usr/bin/python3)";
  }
  return {};
}

void PyTorchYardstick::stop() {
  if (requests_ != nullptr) std::fclose(requests_);
  if (answers_ != nullptr) std::fclose(answers_);
  requests_ = answers_ = nullptr;
  if (process_ > 0) ::waitpid(process_, nullptr, 0);
  process_ = 0;
}

PyTorchYardstick::~PyTorchYardstick() { stop(); }

std::vector<double> PyTorchYardstick::ask(const std::string& request) {
  std::fprintf(requests_, "%s\n", request.c_str());
  std::fflush(requests_);
  std::string line;
  for (int c = std::fgetc(answers_); c != EOF && c != '\n'; c = std::fgetc(answers_)) {
    line += static_cast<char>(c);
  }
  if (line.empty()) throw InputError("PyTorch gave no answer to '" + request + "'");
  std::istringstream words(line);
  if (line.rfind("ready", 0) == 0) words.ignore(5);
  std::vector<double> numbers;
  for (double number = 0.0; words >> number;) numbers.push_back(number);
  return numbers;
}

void PyTorchYardstick::set_threads(int threads) { ask("threads " + std::to_string(threads)); }

void PyTorchYardstick::prepare_convolution(const nn::ConvolutionShape& s, Pass pass) {
  std::ostringstream request;
  request << "convolution";
  for (const int size : {s.batch, s.in_height, s.in_width, s.in_channels, s.out_channels,
                         s.kernel_height, s.kernel_width, s.stride_y, s.stride_x, s.padding_y,
                         s.padding_x, s.dilation_y, s.dilation_x}) {
    request << ' ' << size;
  }
  ask(request.str() + ' ' + pass_name(pass));
}

std::vector<double> PyTorchYardstick::prepare_encoder(
    const std::string& weights, int images, int height, int width, bool backward) {
  std::ostringstream request;
  request << "encoder " << weights << ' ' << images << ' ' << height << ' ' << width << ' '
          << (backward ? "both" : "forward");
  return ask(request.str());
}

std::vector<double> PyTorchYardstick::times(int calls) {
  return ask("time " + std::to_string(calls));
}

}  // namespace imslam::bench
