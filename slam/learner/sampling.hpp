#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "slam/base/parallel.hpp"
#include "slam/learner/gradient_strategy.hpp"

namespace imslam::learner {

/// make(stream) for each of `count` draws, side by side: draw i has stream i of `random`, so the
/// result does not depend on the number of threads. Keeps the order; leaves out empty answers.
template <typename Make>
auto draw_samples(int count, const Random& random, const Make& make) {
  using Answer = decltype(make(std::declval<Random&>()));
  const auto size = static_cast<std::size_t>(count);
  std::vector<Answer> answers(size);
  parallel_for(size, [&](std::size_t i) {
    Random stream = random.fork(static_cast<std::uint64_t>(i));
    answers[i] = make(stream);
  });
  std::vector<typename Answer::value_type> samples;
  for (Answer& answer : answers) {
    if (answer) samples.push_back(std::move(*answer));
  }
  return samples;
}

/// What one draw adds:  U = mean cost,  dU/dz = mean gradient.
struct Contribution {
  double cost = 0.0;
  Vector gradient;
};

/// Means and variance. Fewer contributions than drawn: noted; none: refused.
void take_mean(const std::vector<Contribution>& contributions, int drawn, UpperGradient& result);

}  // namespace imslam::learner
