#include "slam/plugins/routing/allocation_network.hpp"

#include <cmath>
#include <string>

#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/attention.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/reduce.hpp"

namespace imslam::routing {
namespace {

constexpr double kLogitRange = 10.0;

template <typename S>
nn::Var scaled(nn::Tape<S>& tape, nn::Var x, double factor) {
  return nn::multiply(tape, x, tape.constant(nn::Tensor<S>({1}, {static_cast<S>(factor)})));
}

}  // namespace

template <typename S>
AllocationNetwork<S>::AllocationNetwork(int number_of_agents,
                                        const AllocationSizes& given,
                                        Random& random)
    : agents(number_of_agents),
      sizes(given),
      enter(kCityFeatures, given.width, random),
      enter_second(given.width, given.width, random),
      enter_pool(given.width, given.width, random),
      query(2 * given.width, number_of_agents * given.key, random),
      key(given.width, number_of_agents * given.key, random),
      value(given.width, number_of_agents * given.value, random),
      agent_policy({number_of_agents, given.value, given.policy}),
      agent_bias({number_of_agents, 1, given.policy}),
      city_policy(given.width, given.policy, random) {
  for (int l = 0; l < given.layers; ++l) {
    layers.push_back({nn::Linear<S>(given.width, given.width, random),
                      nn::Linear<S>(given.width, given.width, random),
                      nn::Linear<S>(given.width, given.width, random),
                      nn::LayerNorm<S>(given.width)});
    nn::initialise_xavier(layers.back().pool.weight, random);
  }
  for (nn::Linear<S>* layer : {&enter_pool, &query, &key, &value, &city_policy}) {
    nn::initialise_xavier(layer->weight, random);
  }
  // Small: a tanh that is saturated from the start lets no gradient through.
  nn::initialise_uniform(agent_policy, 0.1, random);
  nn::initialise_uniform(agent_bias, 0.1, random);
}

template <typename S>
nn::Var AllocationNetwork<S>::forward(nn::Tape<S>& tape, nn::Var features) const {
  nn::Var h = enter.forward(tape, features, nn::Activation::kRelu);
  h = enter_second.forward(tape, h);
  nn::Var graph = enter_pool.forward(tape, nn::mean(tape, h, {0}, nn::Axes::kKeep));
  nn::Var sum;
  for (const GraphLayer& layer : layers) {
    const nn::Var around = nn::add(tape, h, nn::mean(tape, h, {0}, nn::Axes::kKeep));
    const nn::Var inner = layer.first.forward(tape, around, nn::Activation::kRelu);
    h = nn::relu(tape, layer.norm.forward(tape, layer.second.forward(tape, inner)));
    const nn::Var pooled = nn::mean(tape, h, {0}, nn::Axes::kKeep);
    graph = nn::add(tape, graph, layer.pool.forward(tape, pooled));
    sum = sum ? nn::add(tape, sum, h) : h;
  }
  const nn::Var queries = agent_queries(tape, sum, graph);
  const nn::Index n = tape.shape(features)[0];
  const nn::Var cities = city_policy.forward(tape, nn::slice(tape, sum, 0, 1, n - 1));
  const nn::Var apart = nn::subtract(tape, cities, nn::mean(tape, cities, {0}, nn::Axes::kKeep));
  const nn::Var meeting = nn::matmul(tape, apart, nn::transpose(tape, queries));
  const nn::Var bent = nn::tanh(tape, scaled(tape, meeting, 1.0 / std::sqrt(sizes.policy)));
  return scaled(tape, bent, kLogitRange);
}

/// [agents, policy]
template <typename S>
nn::Var AllocationNetwork<S>::agent_queries(nn::Tape<S>& tape,
                                            nn::Var cities,
                                            nn::Var graph) const {
  const nn::Index n = tape.shape(cities)[0];
  const auto one = [&](nn::Var x) {  // as a batch of one
    return nn::reshape(tape, x, {1, tape.shape(x)[0], tape.shape(x)[1]});
  };
  const nn::Var context = nn::concat(tape, {graph, nn::slice(tape, cities, 0, 0, 1)}, 1);
  const nn::Var others = nn::slice(tape, cities, 0, 1, n - 1);
  const nn::Var seen =
      nn::attention(tape, one(query.forward(tape, context)), one(key.forward(tape, others)),
                    one(value.forward(tape, others)), agents);
  const nn::Var states = nn::reshape(tape, seen, {agents, 1, sizes.value});
  const nn::Var queries = nn::add(tape, nn::matmul(tape, states, tape.parameter(agent_policy)),
                                  tape.parameter(agent_bias));
  return nn::reshape(tape, queries, {agents, sizes.policy});
}

template <typename S>
void AllocationNetwork<S>::collect(nn::ParameterList<S>& list) {
  enter.collect(list, "enter.");
  enter_second.collect(list, "enter_second.");
  enter_pool.collect(list, "enter_pool.");
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const std::string prefix = "layer" + std::to_string(l) + ".";
    layers[l].first.collect(list, prefix + "first.");
    layers[l].second.collect(list, prefix + "second.");
    layers[l].norm.collect(list, prefix + "norm.");
    layers[l].pool.collect(list, prefix + "pool.");
  }
  query.collect(list, "query.");
  key.collect(list, "key.");
  value.collect(list, "value.");
  list.add("agent_policy", agent_policy);
  list.add("agent_bias", agent_bias);
  city_policy.collect(list, "city_policy_centred.");
}

template struct AllocationNetwork<float>;
template struct AllocationNetwork<double>;

}  // namespace imslam::routing
