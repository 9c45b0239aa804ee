#include "slam/learner/control_variate.hpp"

#include "slam/learner/sampling.hpp"

namespace imslam::learner {
namespace {

/// y_i = x_i - mean of all other x: its own transpose, hence the same on the way back.
std::vector<double> less_mean_of_others(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double value : x) sum += value;
  std::vector<double> y;
  for (const double value : x) {
    y.push_back(value - (sum - value) / static_cast<double>(x.size() - 1));
  }
  return y;
}

}  // namespace

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
    sample.rest = sample.cost - surrogate_.value(sample.x, z);
    return sample;
  };
  z_ = z;
  draws_ = draw_samples(options_.samples, random, draw);
  std::vector<double> rests;
  for (const Draw& sample : draws_) rests.push_back(sample.rest);
  if (has_baseline()) rests = less_mean_of_others(rests);
  std::vector<Contribution> contributions;
  for (std::size_t i = 0; i < draws_.size(); ++i) {
    draws_[i].gradient = rests[i] * draws_[i].score + surrogate_.mean_slope(draws_[i].x, z);
  }
  for (const Draw& sample : draws_) contributions.push_back({sample.cost, sample.gradient});
  take_mean(contributions, options_.samples, result);
}

void ControlVariate::teach(Surrogate& surrogate) const {
  const double share = 2.0 / static_cast<double>(std::max<std::size_t>(draws_.size(), 1));
  std::vector<double> weights;  // of each L - s in V
  for (const Draw& sample : draws_) weights.push_back(share * sample.gradient.dot(sample.score));
  if (has_baseline()) weights = less_mean_of_others(weights);
  for (std::size_t i = 0; i < draws_.size(); ++i) {
    surrogate.accumulate(draws_[i].x, z_, -weights[i], share * draws_[i].gradient);
  }
}

}  // namespace imslam::learner
