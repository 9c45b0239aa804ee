#pragma once

namespace imslam::app {

/// From now on SIGINT, SIGTERM and SIGHUP end the process with 128 + their number, as a shell
/// reports them, at once: nothing has been done that would be lost.
void catch_interrupts();

/// While one lives, there is work to save: the first signal only sets a flag, which long loops look
/// at to stop in good order; a second one ends the process at once.
class HeldInterrupts {
 public:
  HeldInterrupts();
  ~HeldInterrupts();
  HeldInterrupts(const HeldInterrupts&) = delete;
  HeldInterrupts& operator=(const HeldInterrupts&) = delete;
};

/// Whether a signal was held.
bool interrupted();

/// 128 + the number of the signal that was held; 0: none.
int interrupt_exit_code();

}  // namespace imslam::app
