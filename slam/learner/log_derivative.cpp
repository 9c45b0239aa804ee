#include "slam/learner/log_derivative.hpp"

#include "slam/learner/sampling.hpp"

namespace imslam::learner {

LogDerivative::LogDerivative(Task& task, const Options& options)
    : problem_(required<SampledProblem>(task, "log_derivative", "SampledProblem")),
      options_(options) {}

void LogDerivative::differentiate(const Vector& z, const Random& random, UpperGradient& result) {
  const auto draw = [&](Random& stream) -> std::optional<Contribution> {
    const Vector x = problem_.draw(z, stream);
    const std::optional<double> cost = problem_.cost(x);
    if (!cost) return std::nullopt;
    return Contribution{*cost, problem_.score(x, z)};
  };
  std::vector<Contribution> samples = draw_samples(options_.samples, random, draw);

  const bool baseline = options_.baseline && samples.size() > 1;
  double sum = 0.0;
  for (const Contribution& sample : samples) sum += sample.cost;
  for (Contribution& sample : samples) {
    const double others = (sum - sample.cost) / static_cast<double>(samples.size() - 1);
    sample.gradient *= sample.cost - (baseline ? others : options_.constant);
  }
  take_mean(samples, options_.samples, result);
}

}  // namespace imslam::learner
