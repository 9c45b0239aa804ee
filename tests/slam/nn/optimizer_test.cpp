#include "slam/nn/training/optimizer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "slam/base/error.hpp"
#include "slam/nn/training/gradients.hpp"
#include "slam/nn/training/schedule.hpp"
#include "slam/nn/weights_io.hpp"

namespace imslam::nn {
namespace {

template <typename S>
struct OneWeight {
  explicit OneWeight(double value) : weight(Shape{1}) {
    weight.value[0] = S(value);
    list.add("w", weight);
  }
  void step(Optimizer<S>& optimizer, double gradient, double rate) {
    Gradients<S> gradients = zero_gradients(list);
    gradients[0][0] = S(gradient);
    optimizer.step(list, gradients, rate);
  }
  Parameter<S> weight;
  ParameterList<S> list;
};

// Two steps by hand, gradients 1 and 2, from w = 10.
TEST(Optimizer, SgdFollowsItsFormula) {
  OneWeight<double> w(10.0);
  Sgd<double> sgd({0.9, false, 0.1});
  w.step(sgd, 1.0, 0.5);
  const double after_one = 10.0 - 0.5 * (1.0 + 0.1 * 10.0);
  EXPECT_DOUBLE_EQ(w.weight.value[0], after_one);
  w.step(sgd, 2.0, 0.5);
  EXPECT_DOUBLE_EQ(w.weight.value[0], after_one - 0.5 * (0.9 * 2.0 + 2.0 + 0.1 * after_one));
}

TEST(Optimizer, NesterovLooksAhead) {
  OneWeight<double> w(10.0);
  Sgd<double> sgd({0.9, true, 0.0});
  w.step(sgd, 1.0, 0.5);
  EXPECT_DOUBLE_EQ(w.weight.value[0], 10.0 - 0.5 * 1.9);
  w.step(sgd, 2.0, 0.5);
  EXPECT_DOUBLE_EQ(w.weight.value[0], 10.0 - 0.5 * 1.9 - 0.5 * (2.0 + 0.9 * 2.9));
}

TEST(Optimizer, RmsPropFollowsItsFormula) {
  OneWeight<double> w(10.0);
  RmsProp<double> rms({0.9, 0.5, 0.0, 0.0});
  w.step(rms, 1.0, 0.1);
  const double first = 1.0 / std::sqrt(0.1);
  EXPECT_DOUBLE_EQ(w.weight.value[0], 10.0 - 0.1 * first);
  w.step(rms, 2.0, 0.1);
  const double second = 0.5 * first + 2.0 / std::sqrt(0.9 * 0.1 + 0.1 * 4.0);
  EXPECT_NEAR(w.weight.value[0], 10.0 - 0.1 * first - 0.1 * second, 1e-14);
}

TEST(Optimizer, AdamFollowsItsFormulaWithBothKindsOfDecay) {
  OneWeight<double> w(10.0);
  Adam<double>::Options options;
  options.weight_decay = 0.01;
  Adam<double> adamw(options);
  w.step(adamw, 1.0, 0.1);
  const double after_one = 10.0 - 0.1 * 0.01 * 10.0 - 0.1 / (1.0 + 1e-8);
  EXPECT_NEAR(w.weight.value[0], after_one, 1e-14);
  w.step(adamw, 2.0, 0.1);
  const double m = (0.9 * 0.1 + 0.2) / (1.0 - 0.81);
  const double s = (0.999 * 0.001 + 0.004) / (1.0 - 0.999 * 0.999);
  EXPECT_NEAR(w.weight.value[0], after_one * (1.0 - 0.001) - 0.1 * m / (std::sqrt(s) + 1e-8),
              1e-12);

  OneWeight<double> coupled(10.0);
  options.decoupled_decay = false;
  Adam<double> adam(options);
  coupled.step(adam, 1.0, 0.1);  // the first step has length `rate` whatever the gradient
  EXPECT_NEAR(coupled.weight.value[0], 9.9, 1e-8);
}

std::vector<std::function<std::unique_ptr<Optimizer<float>>()>> all_rules() {
  return {[] {
            return std::make_unique<Sgd<float>>(Sgd<float>::Options{0.9, true, 0.01});
          },
          [] {
            return std::make_unique<RmsProp<float>>(RmsProp<float>::Options{0.9, 0.9, 1e-8, 0.0});
          },
          [] { return std::make_unique<Adam<float>>(); }};
}

TEST(Optimizer, AllReachTheMinimumOfAParabola) {
  for (const auto& make : all_rules()) {
    OneWeight<float> w(5.0);
    const auto optimizer = make();
    for (int i = 0; i < 2000; ++i) {
      w.step(*optimizer, static_cast<double>(w.weight.value[0]) - 2.0, i < 1000 ? 0.01 : 0.001);
    }
    EXPECT_NEAR(w.weight.value[0], 2.0F, 0.05F);
  }
}

TEST(Optimizer, GoesOnBitByBitFromASavedState) {
  for (const auto& make : all_rules()) {
    OneWeight<float> whole(5.0);
    const auto optimizer = make();
    for (int i = 0; i < 7; ++i) whole.step(*optimizer, std::sin(i), 0.01);
    WeightsWriter writer;
    add_state(writer, "optimizer/", optimizer->state(whole.list));
    const WeightsFile file = WeightsFile::parse("checkpoint", writer.bytes({}));

    OneWeight<float> resumed(static_cast<double>(whole.weight.value[0]));
    const auto other = make();
    other->restore(resumed.list, state_of<float>(file, "optimizer/"));
    for (int i = 7; i < 20; ++i) {
      whole.step(*optimizer, std::sin(i), 0.01);
      resumed.step(*other, std::sin(i), 0.01);
    }
    EXPECT_EQ(whole.weight.value[0], resumed.weight.value[0]);
  }
}

TEST(Optimizer, RefusesAStateThatLacksATensorOrHasItInAnotherShape) {
  OneWeight<float> w(1.0);
  Adam<float> adam;
  w.step(adam, 1.0, 0.1);
  const auto expect_refused = [&](const OptimizerState<float>& state) {
    try {
      Adam<float>().restore(w.list, state);
      ADD_FAILURE() << "expected InputError";
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kModel);
      EXPECT_NE(std::string(error.what()).find("'mean/w'"), std::string::npos) << error.what();
    }
  };
  OptimizerState<float> state = adam.state(w.list);
  ASSERT_EQ(state.tensors[0].name, "mean/w");
  state.tensors[0].name = "mean/v";
  expect_refused(state);
  state = adam.state(w.list);
  state.tensors[0].tensor = Tensor<float>(Shape{2});
  expect_refused(state);
  state = adam.state(w.list);
  state.tensors.erase(state.tensors.begin());
  expect_refused(state);
}

TEST(Optimizer, RefusesAStateWithMoreTensorsAndLeavesFrozenWeightsAlone) {
  OneWeight<float> w(1.0);
  Adam<float> adam;
  w.step(adam, 1.0, 0.1);
  OptimizerState<float> state = adam.state(w.list);
  state.tensors.push_back({"mean/v", Tensor<float>(Shape{1})});
  EXPECT_THROW(adam.restore(w.list, state), ContractError);
  w.weight.trainable = false;
  const float before = w.weight.value[0];
  w.step(adam, 1.0, 0.1);
  EXPECT_EQ(w.weight.value[0], before);
}

TEST(Schedule, StepAndCosineAndOneCycleHaveTheirCorners) {
  const StepSchedule step{1.0, 10, 0.5};
  EXPECT_DOUBLE_EQ(step.rate(9), 1.0);
  EXPECT_DOUBLE_EQ(step.rate(25), 0.25);
  const CosineSchedule cosine{2.0, 110, 10, 0.2};
  EXPECT_DOUBLE_EQ(cosine.rate(0), 0.2);
  EXPECT_DOUBLE_EQ(cosine.rate(9), 2.0);
  EXPECT_DOUBLE_EQ(cosine.rate(10), 2.0);
  EXPECT_NEAR(cosine.rate(60), 1.1, 1e-12);
  EXPECT_NEAR(cosine.rate(110), 0.2, 1e-12);
  EXPECT_NEAR(cosine.rate(1000), 0.2, 1e-12);
  const OneCycleSchedule cycle{1.0, 100, 0.3, 25.0, 1e4};
  EXPECT_NEAR(cycle.rate(0), 0.04, 1e-12);
  EXPECT_NEAR(cycle.rate(30), 1.0, 1e-12);
  EXPECT_NEAR(cycle.rate(100), 1e-4, 1e-12);
}

TEST(Schedule, PlateauFallsWhenNothingGetsBetterAndResumes) {
  PlateauSchedule::Options options;
  options.start = 1.0;
  options.patience = 2;
  PlateauSchedule plateau(options);
  EXPECT_EQ(plateau.observe(5.0), 1.0);
  EXPECT_EQ(plateau.observe(4.0), 1.0);
  EXPECT_EQ(plateau.observe(4.0), 1.0);
  EXPECT_EQ(plateau.observe(std::nan("")), 1.0);
  PlateauSchedule resumed(options);
  resumed.restore(plateau.state());
  EXPECT_DOUBLE_EQ(resumed.observe(4.1), 0.1);
  // A better look ends the row of bad ones.
  for (const double loss : {1.5, 1.0, 1.5, 1.5, 0.5, 1.5, 1.5}) {
    EXPECT_DOUBLE_EQ(resumed.observe(loss), 0.1) << loss;
  }
  EXPECT_DOUBLE_EQ(resumed.observe(1.5), 0.01);
}

TEST(Gradients, AreClippedTogether) {
  OneWeight<float> w(0.0);
  Parameter<float> second(Shape{1});
  w.list.add("second", second);
  Gradients<float> gradients = zero_gradients(w.list);
  gradients[0][0] = 3.0F;
  gradients[1][0] = 4.0F;
  EXPECT_DOUBLE_EQ(clip_network_norms(w.list, gradients, 10.0), 5.0);
  EXPECT_EQ(gradients[0][0], 3.0F);
  EXPECT_DOUBLE_EQ(clip_network_norms(w.list, gradients, 1.0), 5.0);
  EXPECT_FLOAT_EQ(gradients[0][0], 0.6F);
  EXPECT_NEAR(global_norm(gradients), 1.0, 1e-6);
  gradients[0][0] = std::nanf("");
  EXPECT_TRUE(std::isnan(clip_network_norms(w.list, gradients, 1.0)));
}

TEST(Gradients, OfOneNetworkDoNotHoldUpThoseOfAnother) {
  Parameter<float> loud(Shape{1});
  Parameter<float> loud_too(Shape{1});
  Parameter<float> quiet(Shape{1});
  ParameterList<float> list;
  list.add("imu_network/weight", loud);
  list.add("imu_network/bias", loud_too);
  list.add("motion_noise/weight", quiet);
  Gradients<float> gradients = zero_gradients(list);
  gradients[0][0] = 30.0F;
  gradients[1][0] = 40.0F;
  gradients[2][0] = 0.5F;
  EXPECT_NEAR(clip_network_norms(list, gradients, 5.0), std::hypot(50.0, 0.5), 1e-9);
  EXPECT_FLOAT_EQ(gradients[0][0], 3.0F);
  EXPECT_FLOAT_EQ(gradients[1][0], 4.0F);
  EXPECT_EQ(gradients[2][0], 0.5F);
  gradients[2][0] = std::nanf("");
  EXPECT_TRUE(std::isnan(clip_network_norms(list, gradients, 1.0)));
  EXPECT_FLOAT_EQ(gradients[0][0], 3.0F);
}

TEST(WeightAverage, FollowsSlowlyAndSwapsBackAndForth) {
  OneWeight<double> w(1.0);
  WeightAverage<double> average(0.5);
  average.update(w.list);
  w.weight.value[0] = 3.0;
  average.update(w.list);  // decay min(0.5, 2/11)
  const double expected = 2.0 / 11.0 * 1.0 + 9.0 / 11.0 * 3.0;
  average.swap(w.list);
  EXPECT_NEAR(w.weight.value[0], expected, 1e-14);
  average.swap(w.list);
  EXPECT_EQ(w.weight.value[0], 3.0);
}

}  // namespace
}  // namespace imslam::nn
