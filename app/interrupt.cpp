#include "app/interrupt.hpp"

#include <unistd.h>

#include <csignal>
#include <initializer_list>

namespace imslam::app {
namespace {

constexpr int kShellOffset = 128;

// The only things a signal handler may touch.
volatile std::sig_atomic_t g_held = 0;    // NOLINT
volatile std::sig_atomic_t g_signal = 0;  // NOLINT: the first one that came while held

void on_signal(int number) {
  if (g_held == 0 || g_signal != 0) ::_exit(kShellOffset + number);
  g_signal = number;
}

}  // namespace

void catch_interrupts() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (::sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
    action.sa_handler = on_signal;
    ::sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    ::sigaction(number, &action, nullptr);
  }
}

HeldInterrupts::HeldInterrupts() { g_held = 1; }
HeldInterrupts::~HeldInterrupts() { g_held = 0; }

bool interrupted() { return g_signal != 0; }

int interrupt_exit_code() { return g_signal == 0 ? 0 : kShellOffset + g_signal; }

}  // namespace imslam::app
