#include "app/interrupt.hpp"

#include <csignal>
#include <initializer_list>

namespace imslam::app {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;  // NOLINT: the only thing a signal handler may touch

void on_signal(int number) {
  g_interrupted = 1;
  std::signal(number, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, on_signal);
}

bool interrupted() { return g_interrupted != 0; }

}  // namespace imslam::app
