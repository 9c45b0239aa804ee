#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace imslam::nn {

/// Scratch memory of the kernels, kept between calls so that a repeated call allocates nothing.
///
/// Give one workspace to all calls of one thread of control. The kernels lend its pieces to the
/// tasks that they start; which task got which piece never shows in a result.
class Workspace {
 public:
  Workspace() = default;
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  /// At least `floats` floats, aligned to 64 bytes, contents undefined; valid until the next call
  /// with the same slot.
  float* buffer(std::size_t slot, std::size_t floats);

  /// At least `count` positions, contents undefined; valid until the next call.
  std::ptrdiff_t* positions(std::size_t count);

  /// One piece of scratch for the life of this object; thread-safe.
  class Lease {
   public:
    Lease(Workspace& workspace, std::size_t floats);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    float* data() const { return data_; }

   private:
    Workspace& workspace_;
    std::size_t index_ = 0;
    float* data_ = nullptr;
  };

 private:
  struct Free {
    void operator()(float* memory) const;
  };
  struct Block {
    std::unique_ptr<float, Free> memory;
    std::size_t floats = 0;
    float* grow(std::size_t wanted);
  };

  std::vector<Block> slots_;
  std::vector<std::ptrdiff_t> positions_;
  std::mutex mutex_;  // guards what follows
  std::vector<Block> pieces_;
  std::vector<std::size_t> idle_;
};

}  // namespace imslam::nn
