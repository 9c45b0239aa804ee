#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace imslam::nn {

/// Memory that is handed out front to back and taken back all at once.
///
/// Blocks are kept by rewind(): the same sequence of requests after it needs no new memory, so a
/// network that runs once per frame allocates in the first frame only. All pieces start at
/// multiples of 64 bytes (a cache line, the widest vector register), hence equal sequences of
/// operations see equal alignment and give equal bits.
class Arena {
 public:
  static constexpr std::size_t kAlignment = 64;

  /// A position to which one can go back; everything handed out after it is then free again.
  struct Mark {
    std::size_t block = 0;
    std::size_t used = 0;
  };

  void* allocate(std::size_t bytes);

  template <typename T>
  T* allocate_array(std::ptrdiff_t count) {
    return static_cast<T*>(allocate(static_cast<std::size_t>(count) * sizeof(T)));
  }

  Mark mark() const { return here_; }
  void rewind(Mark mark) { here_ = mark; }
  void rewind() { here_ = Mark(); }

  std::size_t capacity() const;  ///< [bytes] held, used or not

 private:
  struct Free {
    void operator()(std::byte* memory) const;
  };
  struct Block {
    std::unique_ptr<std::byte, Free> memory;
    std::size_t size = 0;
  };

  std::vector<Block> blocks_;
  Mark here_;
};

}  // namespace imslam::nn
