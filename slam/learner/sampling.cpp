#include "slam/learner/sampling.hpp"

#include <fmt/format.h>

namespace imslam::learner {

void take_mean(const std::vector<Contribution>& contributions, int drawn, UpperGradient& result) {
  result.samples = static_cast<int>(contributions.size());
  result.solve.converged = result.samples == drawn;
  if (result.samples < drawn) {
    result.note = fmt::format("{} of {} draws did not converge and were left out",
                              drawn - result.samples, drawn);
  }
  if (contributions.empty()) {
    result.refusal = Refusal::kUnconverged;
    return;
  }
  const double count = result.samples;
  result.gradient = Vector::Zero(contributions.front().gradient.size());
  for (const Contribution& sample : contributions) {
    result.cost += sample.cost / count;
    result.gradient += sample.gradient / count;
  }
  if (result.samples < 2) return;
  for (const Contribution& sample : contributions) {
    result.variance += (sample.gradient - result.gradient).squaredNorm() / (count - 1.0);
  }
}

}  // namespace imslam::learner
