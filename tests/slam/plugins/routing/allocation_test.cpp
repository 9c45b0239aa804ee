#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "slam/learner/control_variate.hpp"
#include "slam/learner/log_derivative.hpp"
#include "slam/nn/training/optimizer.hpp"
#include "slam/plugins/routing/allocate.hpp"
#include "slam/plugins/routing/allocation_surrogate.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::routing {
namespace {

using learner::UpperGradient;
using learner::Vector;

constexpr int kAgents = 2;
constexpr int kCities = 6;

AllocationProblem small_problem() {
  Random random(11);
  AllocationProblem problem(kAgents);
  problem.set_instance(random_instance(kCities, random));
  return problem;
}

Vector some_logits() {
  Random random(12);
  Vector z((kCities - 1) * kAgents);
  for (double& value : z) value = random.normal();
  return z;
}

/// E[L] over all ways to share the cities out.
double expected_cost(const AllocationProblem& problem, const Vector& z) {
  const learner::Matrix p = allocation_probabilities(z, kAgents);
  double sum = 0.0;
  for (int way = 0; way < 1 << (kCities - 1); ++way) {
    Vector x(kCities - 1);
    double probability = 1.0;
    for (int i = 0; i < kCities - 1; ++i) {
      x[i] = (way >> i) & 1;
      probability *= p(i, (way >> i) & 1);
    }
    sum += probability * *problem.cost(x);
  }
  return sum;
}

Vector true_gradient(const AllocationProblem& problem, const Vector& z) {
  return imslam::testing::numeric_jacobian(
             [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
               return Vector::Constant(1, expected_cost(problem, at));
             },
             z)
      .transpose();
}

/// A surrogate that says something: its last layers are zero at first.
SurrogateNetwork<float> talkative_surrogate() {
  Random random(13);
  SurrogateNetwork<float> network(random);
  nn::initialise_uniform(network.pair_out.weight, 0.2, random);
  nn::initialise_uniform(network.whole_out.weight, 0.2, random);
  return network;
}

void expect_unbiased(const UpperGradient& upper, const Vector& truth, const char* what) {
  const double standard_error = std::sqrt(upper.variance / upper.samples);
  std::printf("%-24s off by %.5f, standard error %.5f, variance %.4f\n", what,
              (upper.gradient - truth).norm(), standard_error, upper.variance);
  EXPECT_LT((upper.gradient - truth).norm(), 4.0 * standard_error) << what;
}

TEST(AllocationProblem, TheScoreIsTheSlopeOfTheLogProbability) {
  const AllocationProblem problem = small_problem();
  const Vector z = some_logits();
  Random random(1);
  const Vector x = problem.draw(z, random);
  const auto log_probability = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    const learner::Matrix p = allocation_probabilities(at, kAgents);
    double sum = 0.0;
    for (int i = 0; i < kCities - 1; ++i) sum += std::log(p(i, static_cast<int>(x[i])));
    return Vector::Constant(1, sum);
  };
  imslam::testing::expect_near(problem.score(x, z).transpose(),
                               imslam::testing::numeric_jacobian(log_probability, z), 1e-7);
}

TEST(AllocationProblem, AllEstimatorsAreUnbiasedWhateverTheSurrogateSays) {
  AllocationProblem problem = small_problem();
  const Vector z = some_logits();
  const Vector truth = true_gradient(problem, z);
  const SurrogateNetwork<float> network = talkative_surrogate();
  AllocationSurrogate surrogate(network);
  surrogate.look_at(problem, z);
  constexpr int kMany = 30000;
  expect_unbiased(learner::LogDerivative(problem, {kMany, false, 2.0})(z, Random(3)), truth,
                  "constant baseline");
  expect_unbiased(learner::LogDerivative(problem, {kMany, true})(z, Random(3)), truth,
                  "S-sample baseline");
  expect_unbiased(learner::ControlVariate(problem, surrogate, {kMany, false})(z, Random(3)), truth,
                  "control variate");
  expect_unbiased(learner::ControlVariate(problem, surrogate, {kMany, true})(z, Random(3)), truth,
                  "control variate, based");
}

TEST(AllocationSurrogate, LearnsTheVarianceAway) {
  AllocationProblem problem = small_problem();
  const Vector z = some_logits();
  SurrogateNetwork<float> network = talkative_surrogate();
  AllocationSurrogate surrogate(network);
  nn::ParameterList<float> parameters;
  network.collect(parameters);
  nn::Adam<float> optimizer;
  learner::ControlVariate estimator(problem, surrogate, {16, false});
  surrogate.look_at(problem, z);
  const double before =
      learner::ControlVariate(problem, surrogate, {5000, false})(z, Random(5)).variance;
  for (std::uint64_t step = 0; step < 300; ++step) {
    surrogate.look_at(problem, z);
    estimator(z, Random(6).fork(step));
    estimator.teach(surrogate);
    nn::Gradients<float> gradients = nn::zero_gradients(parameters);
    surrogate.add_gradients_to(parameters, gradients);
    optimizer.step(parameters, gradients, 0.01);
  }
  surrogate.look_at(problem, z);
  const double after =
      learner::ControlVariate(problem, surrogate, {5000, false})(z, Random(5)).variance;
  const double based = learner::LogDerivative(problem, {5000, true})(z, Random(5)).variance;
  std::printf("variance: untaught %.4f, taught %.4f, S-sample baseline %.4f\n", before, after,
              based);
  EXPECT_LT(after, 0.01 * before);
  EXPECT_LT(after, 1.3 * based);
}

TEST(AllocationNetwork, GradientsAreThoseOfCentralDifferences) {
  Random random(4);
  AllocationNetwork<double> network(3, {8, 4, 4, 8, 2}, random);
  const Instance instance = random_instance(7, random);
  const nn::Tensor<double> features = nn::cast<double>(city_features(instance));
  nn::ParameterList<double> parameters;
  network.collect(parameters);
  nn::Tape<double> tape;
  const nn::Var z = network.forward(tape, tape.constant(features));
  ASSERT_EQ(tape.shape(z), (nn::Shape{6, 3}));
  nn::Tensor<double> seed({6, 3});
  for (nn::Index i = 0; i < seed.size(); ++i) seed[i] = random.normal();
  tape.backward(z, seed);
  nn::Gradients<double> gradients = nn::zero_gradients(parameters);
  tape.add_gradients_to(parameters, gradients);
  const auto value = [&] {
    nn::Tape<double> probe(nn::Mode::kInference);
    const nn::Var y = network.forward(probe, probe.constant(features));
    return (probe.array(y) * seed.array()).sum();
  };
  for (std::size_t p = 0; p < parameters.count(); ++p) {
    double& weight = parameters[p].value[0];
    const double kept = weight;
    constexpr double kStep = 1e-6;
    weight = kept + kStep;
    const double above = value();
    weight = kept - kStep;
    const double below = value();
    weight = kept;
    EXPECT_NEAR(gradients[p][0], (above - below) / (2.0 * kStep),
                1e-6 * (1.0 + std::abs(gradients[p][0])))
        << parameters[p].name;
  }
}

TEST(AllocationNetwork, WhatAllCitiesHaveInCommonDoesNotReachTheLogits) {
  Random random(4);
  const Instance instance = random_instance(50, random);
  AllocationNetwork<float> network(3, AllocationSizes(), random);
  const Vector z = allocation_logits(network, instance);
  network.city_policy.bias.value.array() += 1.0F;
  EXPECT_LT((allocation_logits(network, instance) - z).norm(), 1e-4);
  // Hence each agent is likely to visit some, from the start.
  const Vector x = likeliest_allocation(z, 3);
  EXPECT_EQ(std::set<double>(x.begin(), x.end()).size(), 3U);
}

TEST(AllocationNetwork, TheOrderOfTheCitiesDoesNotMatter) {
  Random random(4);
  const AllocationNetwork<float> network(3, AllocationSizes(), random);
  Instance instance = random_instance(9, random);
  const Vector z = allocation_logits(network, instance);
  std::swap(instance.points[2], instance.points[5]);
  const Vector swapped = allocation_logits(network, instance);
  EXPECT_LT((z.segment(1 * 3, 3) - swapped.segment(4 * 3, 3)).norm(), 1e-4);
  EXPECT_LT((z.segment(4 * 3, 3) - swapped.segment(1 * 3, 3)).norm(), 1e-4);
  EXPECT_GT((z.segment(1 * 3, 3) - z.segment(4 * 3, 3)).norm(), 1e-4);
}

}  // namespace
}  // namespace imslam::routing
