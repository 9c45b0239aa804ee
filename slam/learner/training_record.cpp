#include "slam/learner/training_record.hpp"

#include <fmt/format.h>

#include <numeric>
#include <vector>

namespace imslam::learner {

std::int64_t BatchTally::refused_samples() const {
  return std::accumulate(refused.begin(), refused.end(), std::int64_t{0});
}

std::string SkipCounts::text() const {
  std::vector<std::string> parts;
  if (not_finite > 0) parts.push_back(fmt::format("{} steps not finite", not_finite));
  if (unsolved > 0) parts.push_back(fmt::format("{} steps without any gradient", unsolved));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i] == 0) continue;
    parts.push_back(fmt::format("{} samples: {}", samples[i], name_of(static_cast<Refusal>(i))));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace imslam::learner
