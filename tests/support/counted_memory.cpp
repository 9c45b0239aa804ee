#include "tests/support/counted_memory.hpp"

#include <malloc.h>

#include <cstddef>
#include <cstdlib>
#include <new>

namespace imslam::testing {
namespace {

void* counted(std::size_t size, std::size_t alignment) {
  CountedMemory& count = counted_memory();
  ++count.allocations;
  const std::size_t rounded = (size + alignment - 1) / alignment * alignment;
  void* const memory = std::aligned_alloc(alignment, rounded);
  if (memory == nullptr) throw std::bad_alloc();
  const long held = count.held_bytes += static_cast<long>(malloc_usable_size(memory));
  if (held > count.most_held_bytes) count.most_held_bytes = held;
  return memory;
}

void release(void* memory) {
  if (memory != nullptr) {
    counted_memory().held_bytes -= static_cast<long>(malloc_usable_size(memory));
  }
  std::free(memory);
}

}  // namespace

CountedMemory& counted_memory() {
  static CountedMemory count;
  return count;
}

}  // namespace imslam::testing

using imslam::testing::counted;
using imslam::testing::release;

void* operator new(std::size_t size) { return counted(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  try {
    return counted(size, alignof(std::max_align_t));
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
