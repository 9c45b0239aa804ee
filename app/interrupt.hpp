#pragma once

namespace imslam::app {

/// From now on SIGINT, SIGTERM and SIGHUP only set a flag; a second one ends the process at once.
void catch_interrupts();

/// Whether a signal has come. Long loops look at it and stop in good order.
bool interrupted();

}  // namespace imslam::app
