#pragma once

#include "slam/learner/sampled_problem.hpp"
#include "slam/nn/layers/linear.hpp"
#include "slam/plugins/routing/allocation_problem.hpp"

namespace imslam::routing {

/// What an allocation costs, told from its probabilities alone: a price c_ij for every city i that
/// agent j gets, and a sum s_0 for all. From how far a city is from the centre of what an agent
/// expects to visit, how long its tour would be, how much longer the longest; sizes of the field do
/// not matter, nor numbers of cities and agents.
template <typename S>
struct SurrogateNetwork {
  static constexpr int kPairFeatures = 7;
  static constexpr int kWholeFeatures = 5;

  SurrogateNetwork() = default;
  explicit SurrogateNetwork(Random& random);

  struct Answer {
    nn::Var prices;  ///< c [pairs, 1], pair (i, j) in row i agents + j
    nn::Var sum;     ///< s_0 [1, 1]
  };
  Answer forward(nn::Tape<S>& tape, nn::Var pairs, nn::Var whole) const;
  void collect(nn::ParameterList<S>& list);

  nn::Linear<S> pair_in, pair_out, whole_in, whole_out;
};

/// The surrogate s of the control variate, linear in who visits whom so that its mean is known:
///
///   s(x) = s_0 + sum_i c_{i, x_i}      s'_ij = d/dz_ij sum_k p_ik c_ik = p_ij (c_ij - sum_k p_ik
///   c_ik)
///
/// c and s_0 may depend on z in any way: they are held in d/dz, as they are in E[s score], so E[s']
/// is exact whatever they are. (A surrogate fed with the log-probability of the draw and
/// differentiated through it, as in the paper, has no such law.)
///
/// One per slot of a batch; all share one network, which only gets its gradients from here.
class AllocationSurrogate : public learner::Surrogate {
 public:
  explicit AllocationSurrogate(const SurrogateNetwork<float>& network) : network_(network) {}

  /// Before value() and mean_slope() at this z of this problem.
  void look_at(const AllocationProblem& problem, const learner::Vector& z);

  double value(const learner::Vector& x, const learner::Vector& z) const override;
  learner::Vector mean_slope(const learner::Vector& x, const learner::Vector& z) const override;
  void accumulate(const learner::Vector& x,
                  const learner::Vector& z,
                  double dvalue,
                  const learner::Vector& dslope) override;
  /// The network is moved by whoever holds it, after add_gradients_to() of all slots.
  void step() override {}

  /// Sends what accumulate() collected through the network; adds to the gradients.
  void add_gradients_to(const nn::ParameterList<float>& parameters, nn::Gradients<float>& sums);

 private:
  const SurrogateNetwork<float>& network_;
  nn::Tape<float> tape_;
  SurrogateNetwork<float>::Answer answer_;
  learner::Matrix probabilities_;
  learner::Matrix prices_;   ///< c, cities x agents
  learner::Matrix dprices_;  ///< dV/dc
  double sum_ = 0.0;
  double dsum_ = 0.0;
};

}  // namespace imslam::routing
