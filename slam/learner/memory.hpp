#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "slam/nn/weights_io.hpp"

namespace imslam::learner {

/// M(gamma, nu) of the bilevel problem: what a task has seen and keeps, be it a map, a rule set or
/// a replay buffer. A Query finds Items again.
template <typename Item, typename Query, typename Answer>
class Memory {
 public:
  virtual ~Memory() = default;

  virtual void write(const Item& item) = 0;
  virtual Answer read(const Query& query) const = 0;
  virtual std::size_t size() const = 0;

  // The whole content within a checkpoint, all names behind `prefix`.
  virtual void save(nn::WeightsWriter& writer, const std::string& prefix) const = 0;
  virtual void restore(const nn::WeightsFile& file, const std::string& prefix) = 0;
};

}  // namespace imslam::learner
