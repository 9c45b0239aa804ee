#pragma once

#include <memory>
#include <vector>

#include "slam/learner/imperative_loss.hpp"
#include "slam/learner/imperative_training.hpp"
#include "slam/learner/make_strategy.hpp"
#include "slam/nn/layers/linear.hpp"
#include "tests/slam/learner/quadratic_task.hpp"

namespace imslam::learner::testing {

struct ToyOptions : TrainingOptions {
  StrategyOptions learner;
  int fails_every = 0;  ///< every n-th sample has a solver that stops half-way; 0: none
  ToyOptions() {
    steps = 40;
    batch = 6;
    rate = 0.05;
    warm_up = 2;
    weight_decay = 0.0;
    average = 0.5;
    validation_every = 4;
    checkpoint_every = 3;
    learner.strategy = "implicit_direct";
  }
  void describe(Config& config) {
    describe_training(config);
    config.field("fails_every", fails_every, "samples");
    config.section("learner", learner);
  }
  void validate() const { validate_training(); }
};

/// A network that must say the z(x) whose solution phi*(z) is near goal(x); nobody tells it z.
class ToyTraining : public ImperativeTraining {
 public:
  explicit ToyTraining(const ToyOptions& options)
      : ImperativeTraining(options, text_of_training(options)),
        options_(options),
        tasks_(static_cast<std::size_t>(options.batch)) {
    Random random(static_cast<std::uint64_t>(options.seed));
    network_ = nn::Linear<float>(2, 2, random);
    nn::ParameterList<float> parameters;
    network_.collect(parameters, "");
    adopt(parameters);
    for (QuadraticTask& task : tasks_) {
      task.direct.setZero();
      strategies_.push_back(make_strategy(options.learner, task));
    }
  }

  ValidationRecord look() override {
    const double loss = with_average([this] {
      double sum = 0.0;
      for (std::uint64_t i = 0; i < 20; ++i) {
        nn::Tape<float> tape(nn::Mode::kInference);
        const nn::Tensor<float> x = input(Random(99).fork(i));
        const nn::Var z = network_.forward(tape, tape.constant(x));
        QuadraticTask task;
        prepare(x, task);
        task.solve(numbers_of(tape, z));
        sum += task.upper_cost().cost / 20.0;
      }
      return sum;
    });
    return {loss, "loss " + std::to_string(loss), std::to_string(loss)};
  }
  std::string log_columns() const override { return "loss_again"; }
  std::string name() const override { return "toy"; }
  nn::ModelCard card() const override { return {}; }

 private:
  static nn::Tensor<float> input(Random random) {
    nn::Tensor<float> x({1, 2});
    x[0] = static_cast<float>(random.normal());
    x[1] = static_cast<float>(random.normal());
    return x;
  }
  static void prepare(const nn::Tensor<float>& x, QuadraticTask& task) {
    task.direct.setZero();
    task.goal << 0.3 * double(x[0]), -0.2 * double(x[1]) + 0.1, 0.1 * double(x[0]);
  }

  nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) override {
    const std::uint64_t index = static_cast<std::uint64_t>(step_count()) * tasks_.size() + slot;
    const nn::Tensor<float> x = input(Random(1).fork(index));
    prepare(x, tasks_[slot]);
    tasks_[slot].converges = options_.fails_every == 0 ||
                             (index + 1) % static_cast<std::uint64_t>(options_.fails_every) != 0;
    const nn::Var z = network_.forward(tape, tape.constant(x));
    return through_solver(tape, z, *strategies_[slot], Random(2).fork(index), slot);
  }

  ToyOptions options_;
  nn::Linear<float> network_;
  std::vector<QuadraticTask> tasks_;
  std::vector<std::unique_ptr<GradientStrategy>> strategies_;
};

}  // namespace imslam::learner::testing
