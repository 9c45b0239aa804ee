#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slam/learner/control_variate.hpp"
#include "slam/learner/imperative_training.hpp"
#include "slam/plugins/routing/allocation_improvement.hpp"
#include "slam/plugins/routing/allocation_network.hpp"
#include "slam/plugins/routing/allocation_surrogate.hpp"

namespace imslam::routing {

/// How the gradient goes through the solver; see learner/sampled_problem.hpp.
///   constant_baseline   REINFORCE, `constant` taken off each cost
///   sample_baseline     REINFORCE, less the mean cost of the other draws (Hu et al. 2020)
///   control_variate     less what the surrogate explains, which is put back without noise (iMTSP);
///                       with two draws or more, what is left is held against the other draws too
///   alternating         no draws: a search betters the network's answer, which learns it
///                       (allocation_improvement.hpp)
struct RoutingTrainingOptions : learner::TrainingOptions {
  int agents = 10;
  int cities = 100;     ///< of the smallest instances, the depot included
  int most_cities = 0;  ///< of the largest, as many of each doubling; 0: all are as large
  std::string estimator = "control_variate";
  int samples = 8;                 ///< allocations drawn per instance; sample_baseline: 2 or more
  double constant = 2.0;           ///< of constant_baseline
  double surrogate_rate = 0.0003;  ///< learning rate of the surrogate
  double effort = 5.0;             ///< of alternating: iterations of its search per city

  RoutingTrainingOptions();
  void describe(Config& config);
  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
};

/// Trains the allocation network on random instances, a new one for every sample.
class RoutingTraining : public learner::ImperativeTraining {
 public:
  explicit RoutingTraining(const RoutingTrainingOptions& options);

  /// Mean longest tour of held-out instances: to the likeliest agent each, and drawn.
  learner::ValidationRecord look() override;
  Instance held_out(int index) const;  ///< of those
  std::string log_columns() const override { return "longest_likeliest,longest_drawn"; }
  std::string name() const override;
  nn::ModelCard card() const override;

  /// Without a step: how much the gradient of a batch scatters with this estimator, over `batches`
  /// batches of held-out instances, summed over all weights.
  double gradient_variance(const std::string& estimator, int batches);

 private:
  nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) override;
  void finish_step() override;
  void save_more(nn::WeightsWriter& writer) const override;
  void restore_more(const nn::WeightsFile& checkpoint) override;
  nn::ParameterList<float> surrogate_parameters() const;
  bool has_surrogate() const { return options_.estimator == "control_variate"; }
  std::unique_ptr<learner::GradientStrategy> make_estimator(const std::string& estimator,
                                                            std::size_t slot);
  Instance draw_instance(Random& random) const;
  nn::Var allocate(nn::Tape<float>& tape,
                   std::size_t slot,
                   Random random,
                   learner::GradientStrategy& estimator);

  RoutingTrainingOptions options_;
  AllocationNetwork<float> network_;
  mutable SurrogateNetwork<float> surrogate_;
  nn::Adam<float> surrogate_optimizer_;
  std::vector<AllocationProblem> problems_;                           ///< one per slot
  std::vector<std::unique_ptr<AllocationImprovement>> improvements_;  ///< likewise
  std::vector<std::unique_ptr<AllocationSurrogate>> surrogates_;      ///< likewise
  std::vector<std::unique_ptr<learner::GradientStrategy>> estimators_;
};

}  // namespace imslam::routing
