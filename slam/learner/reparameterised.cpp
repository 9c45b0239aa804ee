#include "slam/learner/reparameterised.hpp"

#include "slam/learner/sampling.hpp"

namespace imslam::learner {

Reparameterised::Reparameterised(Task& task, const Options& options)
    : problem_(required<ReparameterisedProblem>(task, "reparameterised", "ReparameterisedProblem")),
      options_(options) {}

void Reparameterised::differentiate(const Vector& z, const Random& random, UpperGradient& result) {
  const auto draw = [&](Random& stream) -> std::optional<Contribution> {
    const Vector noise = problem_.draw_noise(stream);
    const auto slope = problem_.cost_slope(problem_.transform(z, noise));
    if (!slope) return std::nullopt;
    return Contribution{slope->cost, problem_.pull_back(z, noise, slope->by_x)};
  };
  take_mean(draw_samples(options_.samples, random, draw), options_.samples, result);
}

}  // namespace imslam::learner
