#include "slam/learner/control_variate.hpp"

#include "slam/learner/sampling.hpp"

namespace imslam::learner {

ControlVariate::ControlVariate(Task& task, const Surrogate& surrogate, const Options& options)
    : problem_(required<SampledProblem>(task, "control_variate", "SampledProblem")),
      surrogate_(surrogate),
      options_(options) {}

void ControlVariate::differentiate(const Vector& z, const Random& random, UpperGradient& result) {
  const auto draw = [&](Random& stream) -> std::optional<Draw> {
    Draw sample;
    sample.x = problem_.draw(z, stream);
    const std::optional<double> cost = problem_.cost(sample.x);
    if (!cost) return std::nullopt;
    sample.cost = *cost;
    sample.score = problem_.score(sample.x, z);
    sample.gradient = (sample.cost - surrogate_.value(sample.x, z)) * sample.score +
                      surrogate_.mean_slope(sample.x, z);
    return sample;
  };
  z_ = z;
  draws_ = draw_samples(options_.samples, random, draw);
  std::vector<Contribution> contributions;
  for (const Draw& sample : draws_) contributions.push_back({sample.cost, sample.gradient});
  take_mean(contributions, options_.samples, result);
}

void ControlVariate::teach(Surrogate& surrogate) const {
  const double share = 2.0 / static_cast<double>(std::max<std::size_t>(draws_.size(), 1));
  for (const Draw& sample : draws_) {
    surrogate.accumulate(sample.x, z_, -share * sample.gradient.dot(sample.score),
                         share * sample.gradient);
  }
}

}  // namespace imslam::learner
