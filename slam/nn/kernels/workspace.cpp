#include "slam/nn/kernels/workspace.hpp"

#include <new>

namespace imslam::nn {
namespace {

constexpr std::align_val_t kAlignment{64};

}  // namespace

void Workspace::Free::operator()(float* memory) const { ::operator delete(memory, kAlignment); }

float* Workspace::Block::grow(std::size_t wanted) {
  if (wanted > floats) {
    memory.reset();
    memory.reset(static_cast<float*>(::operator new(wanted * sizeof(float), kAlignment)));
    floats = wanted;
  }
  return memory.get();
}

float* Workspace::buffer(std::size_t slot, std::size_t floats) {
  if (slot >= slots_.size()) slots_.resize(slot + 1);
  return slots_[slot].grow(floats);
}

std::ptrdiff_t* Workspace::positions(std::size_t count) {
  if (count > positions_.size()) positions_.resize(count);
  return positions_.data();
}

Workspace::Lease::Lease(Workspace& workspace, std::size_t floats) : workspace_(workspace) {
  const std::lock_guard lock(workspace.mutex_);
  if (workspace.idle_.empty()) {
    workspace.idle_.reserve(workspace.pieces_.size() + 1);
    workspace.idle_.push_back(workspace.pieces_.size());
    workspace.pieces_.emplace_back();
  }
  data_ = workspace.pieces_[workspace.idle_.back()].grow(floats);
  index_ = workspace.idle_.back();
  workspace.idle_.pop_back();
}

Workspace::Lease::~Lease() {
  const std::lock_guard lock(workspace_.mutex_);
  workspace_.idle_.push_back(index_);  // within the capacity reserved above
}

}  // namespace imslam::nn
