#pragma once

#include "slam/base/random.hpp"
#include "slam/nn/layers/linear.hpp"
#include "slam/nn/layers/norm.hpp"
#include "slam/plugins/routing/city_features.hpp"

namespace imslam::routing {

/// Sizes of the network. Those of the shipped weights are the defaults.
struct AllocationSizes {
  int width = 64;   ///< of the cities' features
  int key = 16;     ///< per agent
  int value = 16;   ///< per agent
  int policy = 64;  ///< in which agents and cities meet
  int layers = 3;   ///< of the graph network
};

/// Which agent should visit which city.
///
///   h_0 = MLP(features)     h_{l+1} = relu(norm(MLP(h_l + mean of all h_l)))
///   h = h_1 + ... + h_L
///
///   g = sum_l W_l mean(h_l)
///
///   a_j = attention of agent j on all cities, asked by [g, h of the depot]; weights of its own
///
///   z_ij = 10 tanh(q_j(a_j)^T (k(h_i) - mean of all k(h_i)) / sqrt(policy))
///
///   P(city i to agent j) = softmax_j z_ij
///
/// Without the mean taken off, what all cities have in common (h is positive) outweighs what tells
/// them apart: the agents' logits drift into the flat ends of the tanh, all cities alike, and stay.
///
/// The graph is complete, so neighbours are all cities, as many as there are. norm is that of each
/// city by itself (Ba et al. 2016), not of the batch: one instance alone, or a large one, is seen
/// as those of the training were.
template <typename S>
struct AllocationNetwork {
  AllocationNetwork() = default;
  AllocationNetwork(int number_of_agents, const AllocationSizes& sizes, Random& random);

  /// features [n, kCityFeatures] -> z [n - 1, agents] of all cities but the depot
  nn::Var forward(nn::Tape<S>& tape, nn::Var features) const;
  void collect(nn::ParameterList<S>& list);

  struct GraphLayer {
    nn::Linear<S> first, second, pool;
    nn::LayerNorm<S> norm;
  };
  int agents = 0;
  AllocationSizes sizes;
  nn::Linear<S> enter, enter_second, enter_pool;
  std::vector<GraphLayer> layers;
  nn::Linear<S> query, key, value;  ///< all agents side by side
  nn::Parameter<S> agent_policy;    ///< [agents, value, policy]
  nn::Parameter<S> agent_bias;      ///< [agents, 1, policy]
  nn::Linear<S> city_policy;

 private:
  nn::Var agent_queries(nn::Tape<S>& tape, nn::Var cities, nn::Var graph) const;
};

}  // namespace imslam::routing
