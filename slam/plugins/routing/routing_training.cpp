#include "slam/plugins/routing/routing_training.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"
#include "slam/learner/alternating.hpp"
#include "slam/learner/bounds.hpp"
#include "slam/learner/imperative_loss.hpp"
#include "slam/learner/log_derivative.hpp"
#include "slam/nn/ops/softmax.hpp"
#include "slam/plugins/routing/allocate.hpp"

namespace imslam::routing {
namespace {

const std::vector<std::string> kEstimators = {"constant_baseline", "sample_baseline",
                                              "control_variate", "alternating"};
constexpr std::uint64_t kHeldOut = 0x4E1D;  ///< stream of instances that no training sees

const RoutingTrainingOptions& validated(const RoutingTrainingOptions& options) {
  options.validate();
  return options;
}

AllocationNetwork<float> first_network(const RoutingTrainingOptions& options) {
  Random random(static_cast<std::uint64_t>(options.seed));
  return {options.agents, AllocationSizes(), random};
}

SurrogateNetwork<float> first_surrogate(const RoutingTrainingOptions& options) {
  Random random = Random(static_cast<std::uint64_t>(options.seed)).fork(1);
  return SurrogateNetwork<float>(random);
}

std::string text_of_sizes(const RoutingTrainingOptions& options) {
  if (options.most_cities <= options.cities) return fmt::format("{}", options.cities);
  return fmt::format("{} to {}", options.cities, options.most_cities);
}

std::string text_of_lessons(const RoutingTrainingOptions& options) {
  if (options.estimator != "alternating") return fmt::format("{} draws each", options.samples);
  return fmt::format("{} iterations of its search per city", options.effort);
}

/// Sum over all numbers of their variance over the batches.
double scatter(const std::vector<nn::Gradients<float>>& batches) {
  const auto count = static_cast<double>(batches.size());
  double sum = 0.0;
  for (std::size_t p = 0; p < batches.front().size(); ++p) {
    for (nn::Index i = 0; i < batches.front()[p].size(); ++i) {
      double mean = 0.0, squares = 0.0;
      for (const auto& batch : batches) mean += static_cast<double>(batch[p][i]) / count;
      for (const auto& batch : batches)
        squares += std::pow(static_cast<double>(batch[p][i]) - mean, 2);
      sum += squares / (count - 1.0);
    }
  }
  return sum;
}

}  // namespace

RoutingTrainingOptions::RoutingTrainingOptions() {
  steps = 800;
  batch = 32;
  rate = 4e-4;  // twice as much drives the logits into the flat ends of their tanh
  warm_up = 20;
  weight_decay = 0.0;
  clip = 100.0;
  average = 0.95;
  validation_every = 100;
  validation_samples = 64;
  checkpoint_every = 25;
}

void RoutingTrainingOptions::describe(Config& config) {
  describe_training(config);
  config.field("agents", agents, "of the network, each has weights of its own");
  config.field("cities", cities, "of the smallest instances, the depot included");
  config.field("most_cities", most_cities,
               "of the largest, as many of each doubling; 0: all are as large");
  config.field("estimator", estimator, kEstimators, "the gradient's way through the solver");
  config.field("samples", samples, "allocations drawn per instance");
  config.field("constant", constant, "taken off each cost by constant_baseline");
  config.field("surrogate_rate", surrogate_rate, "learning rate of control_variate's surrogate");
  config.field("effort", effort, "of alternating: iterations of its search per city");
}

void RoutingTrainingOptions::validate() const {
  validate_training();
  learner::require_within("train.agents", agents, 1, 100);
  learner::require_within("train.cities", cities, 2, 10000);
  learner::require_within("train.most_cities", most_cities, 0, 10000);
  learner::require_within("train.effort", effort, 0.0, 1e6);
  learner::require_within("train.samples", samples, estimator == "sample_baseline" ? 2 : 1, 1000);
  learner::require_within("train.constant", constant, -1e6, 1e6);
  learner::require_within("train.surrogate_rate", surrogate_rate, 0.0, 1.0);
}

RoutingTraining::RoutingTraining(const RoutingTrainingOptions& options)
    : ImperativeTraining(validated(options), learner::text_of_training(options)),
      options_(options),
      network_(first_network(options)),
      surrogate_(first_surrogate(options)),
      problems_(static_cast<std::size_t>(options.batch), AllocationProblem(options.agents)) {
  nn::ParameterList<float> parameters;
  network_.collect(parameters);
  adopt(parameters);
  for (std::size_t slot = 0; slot < problems_.size(); ++slot) {
    surrogates_.push_back(std::make_unique<AllocationSurrogate>(surrogate_));
    improvements_.push_back(
        std::make_unique<AllocationImprovement>(problems_[slot], options_.effort));
    estimators_.push_back(make_estimator(options_.estimator, slot));
  }
}

std::unique_ptr<learner::GradientStrategy> RoutingTraining::make_estimator(
    const std::string& estimator, std::size_t slot) {
  if (estimator == "control_variate") {
    return std::make_unique<learner::ControlVariate>(
        problems_[slot], *surrogates_[slot],
        learner::ControlVariate::Options{options_.samples, options_.samples > 1});
  }
  if (estimator == "alternating") {
    return std::make_unique<learner::Alternating>(*improvements_[slot], learner::Convergence());
  }
  const bool baseline = estimator == "sample_baseline";
  return std::make_unique<learner::LogDerivative>(
      problems_[slot],
      learner::LogDerivative::Options{options_.samples, baseline, options_.constant});
}

/// Sizes are even on a scale of logarithms.
Instance RoutingTraining::draw_instance(Random& random) const {
  const double least = options_.cities;
  const double most = std::max(options_.most_cities, options_.cities);
  const double cities = most > least ? least * std::pow(most / least, random.uniform()) : least;
  return random_instance(static_cast<int>(std::lround(cities)), random);
}

nn::Var RoutingTraining::allocate(nn::Tape<float>& tape,
                                  std::size_t slot,
                                  Random random,
                                  learner::GradientStrategy& estimator) {
  problems_[slot].set_instance(draw_instance(random));
  const nn::Tensor<float> features = city_features(problems_[slot].instance());
  const nn::Var z = network_.forward(tape, tape.constant(features));
  if (has_surrogate()) surrogates_[slot]->look_at(problems_[slot], learner::numbers_of(tape, z));
  return through_solver(tape, z, estimator, random.fork(1), slot);
}

nn::Var RoutingTraining::sample_loss(nn::Tape<float>& tape, std::size_t slot) {
  const std::uint64_t index =
      static_cast<std::uint64_t>(step_count()) * static_cast<std::uint64_t>(options_.batch) + slot;
  return allocate(tape, slot, Random(static_cast<std::uint64_t>(options_.seed)).fork(index + 2),
                  *estimators_[slot]);
}

double RoutingTraining::gradient_variance(const std::string& estimator, int batches) {
  nn::ParameterList<float> parameters;
  network_.collect(parameters);
  const auto slots = problems_.size();
  std::vector<std::unique_ptr<learner::GradientStrategy>> estimators;
  for (std::size_t slot = 0; slot < slots; ++slot) {
    estimators.push_back(make_estimator(estimator, slot));
  }
  nn::DataParallel<float> batch(parameters, thread_count());
  std::vector<nn::Gradients<float>> all;
  for (int b = 0; b < batches; ++b) {
    all.push_back(nn::zero_gradients(parameters));
    batch.run(
        slots,
        [&](nn::Tape<float>& tape, std::size_t slot) {
          const std::uint64_t index = static_cast<std::uint64_t>(b) * slots + slot;
          return allocate(tape, slot, Random(kHeldOut).fork(index), *estimators[slot]);
        },
        all.back());
  }
  return scatter(all);
}

/// The surrogate learns from the batch that has just run: all slots' lessons in their order.
void RoutingTraining::finish_step() {
  if (!has_surrogate()) return;
  const nn::ParameterList<float> parameters = surrogate_parameters();
  nn::Gradients<float> sums = nn::zero_gradients(parameters);
  for (std::size_t slot = 0; slot < problems_.size(); ++slot) {
    if (!outcomes()[slot].usable()) continue;
    const auto& estimator = static_cast<learner::ControlVariate&>(*estimators_[slot]);
    estimator.teach(*surrogates_[slot]);
    surrogates_[slot]->add_gradients_to(parameters, sums);
  }
  surrogate_optimizer_.step(parameters, sums, options_.surrogate_rate);
}

Instance RoutingTraining::held_out(int index) const {
  Random random = Random(kHeldOut).fork(static_cast<std::uint64_t>(index));
  return draw_instance(random);
}

learner::ValidationRecord RoutingTraining::look() {
  const auto count = static_cast<std::size_t>(options_.validation_samples);
  std::vector<double> likeliest(count), drawn(count);
  with_average([&] {
    parallel_for(count, [&](std::size_t i) {
      AllocationProblem problem(options_.agents);
      problem.set_instance(held_out(static_cast<int>(i)));
      Random random = Random(kHeldOut).fork(i).fork(1);
      const learner::Vector z = allocation_logits(network_, problem.instance());
      likeliest[i] = *problem.cost(likeliest_allocation(z, options_.agents));
      drawn[i] = *problem.cost(problem.draw(z, random));
    });
    return 0;
  });
  double mean_likeliest = 0.0, mean_drawn = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    mean_likeliest += likeliest[i] / static_cast<double>(count);
    mean_drawn += drawn[i] / static_cast<double>(count);
  }
  return {mean_likeliest,
          fmt::format("longest tour {:.3f} (likeliest agents), {:.3f} (drawn)", mean_likeliest,
                      mean_drawn),
          fmt::format("{:.5f},{:.5f}", mean_likeliest, mean_drawn)};
}

std::string RoutingTraining::name() const {
  return fmt::format("allocation_network_{}", options_.agents);
}

nn::ModelCard RoutingTraining::card() const {
  nn::ModelCard card;
  card.what = fmt::format(
      "allocation network of imslam's routing plugin: shares cities of the plane out to {} agents "
      "so that the longest tour is short",
      options_.agents);
  const std::string cities = text_of_sizes(options_);
  card.data =
      fmt::format("{} random instances of {} uniform cities, depot random, estimator {}, {}",
                  static_cast<std::int64_t>(step_count()) * options_.batch, cities,
                  options_.estimator, text_of_lessons(options_));
  card.seed = fmt::format("{}", options_.seed);
  card.metrics =
      fmt::format("{} held-out random instances of {} cities", options_.validation_samples, cities);
  card.limits =
      "uniform cities; other distributions, or many more cities, are not what it was trained on";
  return card;
}

nn::ParameterList<float> RoutingTraining::surrogate_parameters() const {
  nn::ParameterList<float> parameters;
  surrogate_.collect(parameters);
  return parameters;
}

void RoutingTraining::save_more(nn::WeightsWriter& writer) const {
  if (!has_surrogate()) return;
  const nn::ParameterList<float> parameters = surrogate_parameters();
  for (const nn::Parameter<float>* parameter : parameters) {
    writer.add("surrogate/" + parameter->name, parameter->value);
  }
  nn::add_state(writer, "surrogate_optimizer/", surrogate_optimizer_.state(parameters));
}

void RoutingTraining::restore_more(const nn::WeightsFile& checkpoint) {
  if (!has_surrogate()) return;
  const nn::ParameterList<float> parameters = surrogate_parameters();
  for (nn::Parameter<float>* parameter : parameters) {
    checkpoint.read_into("surrogate/" + parameter->name, parameter->value);
  }
  surrogate_optimizer_.restore(parameters, nn::state_of<float>(checkpoint, "surrogate_optimizer/"));
}

}  // namespace imslam::routing
