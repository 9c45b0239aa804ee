#pragma once

#include <gtest/gtest.h>

#include <string>

#include "slam/base/file.hpp"
#include "slam/base/parallel.hpp"
#include "slam/learner/training_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::learner::testing {

/// Trains with one thread and with two; the checkpoints must be the same bytes.
template <typename Training, typename Options>
void expect_threads_change_nothing(const Options& options) {
  const imslam::testing::TempDir dir;
  const auto train = [&](int threads) {
    set_thread_count(threads);
    Training training(options);
    while (!training.done()) training.step();
    const auto file = dir.path() / std::to_string(threads);
    training.save(file);
    set_thread_count(0);
    return read_file(file);
  };
  EXPECT_EQ(train(1), train(2));
}

/// Trains in one go and with a stop every three steps; `weights` is the name of the weight file.
template <typename Training, typename Options>
void expect_resume_bit_by_bit(const Options& options, const std::string& weights) {
  const imslam::testing::TempDir dir;
  TrainingRequest request;
  request.folder = dir.path() / "whole";
  run_training<Training>(options, request);
  request.folder = dir.path() / "pieces";
  request.resume = true;
  request.keep_going = [](int done, int, const std::string&) { return done % 3 != 0; };
  while (run_training<Training>(options, request).stopped) {
  }
  for (const std::string& name :
       {std::string("checkpoint.safetensors"), weights, std::string("log.csv")}) {
    EXPECT_EQ(read_file(dir.path() / "whole" / name), read_file(dir.path() / "pieces" / name))
        << name;
  }
}

}  // namespace imslam::learner::testing
