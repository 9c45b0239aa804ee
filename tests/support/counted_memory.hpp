#pragma once

#include <atomic>

namespace imslam::testing {

/// Every `new` of an executable into which counted_memory.cpp is compiled.
struct CountedMemory {
  std::atomic<long> allocations{0};
  std::atomic<long> held_bytes{0};
  std::atomic<long> most_held_bytes{0};
};

CountedMemory& counted_memory();

}  // namespace imslam::testing
