#include "slam/nn/arena.hpp"

#include <algorithm>
#include <new>

namespace imslam::nn {
namespace {

constexpr std::size_t kSmallestBlock = std::size_t{1} << 20U;
constexpr std::align_val_t kAlign{Arena::kAlignment};

}  // namespace

void Arena::Free::operator()(std::byte* memory) const { ::operator delete(memory, kAlign); }

void* Arena::allocate(std::size_t bytes) {
  const std::size_t rounded =
      (std::max<std::size_t>(bytes, 1) + kAlignment - 1) & ~(kAlignment - 1);
  if (rounded < bytes) throw std::bad_alloc();
  while (here_.block < blocks_.size()) {
    const Block& block = blocks_[here_.block];
    if (block.size - here_.used >= rounded) {
      std::byte* const piece = block.memory.get() + here_.used;
      here_.used += rounded;
      return piece;
    }
    here_ = {here_.block + 1, 0};
  }
  // Growing by what is held already keeps the number of blocks logarithmic.
  const std::size_t size =
      std::max({rounded, kSmallestBlock, std::min(capacity(), 64 * kSmallestBlock)});
  Block block;
  block.memory.reset(static_cast<std::byte*>(::operator new(size, kAlign)));
  block.size = size;
  blocks_.push_back(std::move(block));
  here_ = {blocks_.size() - 1, rounded};
  return blocks_.back().memory.get();
}

std::size_t Arena::capacity() const {
  std::size_t sum = 0;
  for (const Block& block : blocks_) sum += block.size;
  return sum;
}

}  // namespace imslam::nn
