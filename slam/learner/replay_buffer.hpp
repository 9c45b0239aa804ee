#pragma once

#include <cstdint>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/learner/lower_problem.hpp"
#include "slam/learner/memory.hpp"

namespace imslam::learner {

/// What to draw from a replay buffer.
struct Replay {
  std::size_t count = 1;
  Random random;  ///< a stream of its own: equal streams, equal draws
};

/// A fair sample of all that was ever written, in bounded memory: item n (from 1) replaces a random
/// one with probability capacity / n (reservoir sampling; Vitter 1985), so that what was seen long
/// ago is not forgotten. The choice depends on the seed and n only, hence a buffer that is saved
/// and restored goes on bit by bit.
class ReplayBuffer : public Memory<Vector, Replay, std::vector<Vector>> {
 public:
  ReplayBuffer(std::size_t capacity, std::uint64_t seed);

  /// All items are as long as the first.
  void write(const Vector& item) override;
  /// With repetition, in the order drawn. Empty if nothing was written yet.
  std::vector<Vector> read(const Replay& query) const override;

  std::size_t size() const override { return items_.size(); }
  std::uint64_t written() const { return written_; }

  void save(nn::WeightsWriter& writer, const std::string& prefix) const override;
  void restore(const nn::WeightsFile& file, const std::string& prefix) override;

 private:
  std::size_t capacity_;
  Random random_;  ///< only forked
  std::uint64_t written_ = 0;
  std::vector<Vector> items_;
};

}  // namespace imslam::learner
