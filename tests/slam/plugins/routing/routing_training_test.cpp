#include "slam/plugins/routing/routing_training.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/parallel.hpp"
#include "slam/learner/training_run.hpp"
#include "slam/plugins/routing/routing_solver.hpp"
#include "slam/plugins/routing/routing_weights.hpp"
#include "slam/plugins/routing/variance_study.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::routing {
namespace {

RoutingTrainingOptions small(const std::string& estimator) {
  RoutingTrainingOptions options;
  options.agents = 3;
  options.cities = 10;
  options.most_cities = 14;
  options.estimator = estimator;
  options.samples = 2;
  options.steps = 6;
  options.batch = 4;
  options.warm_up = 1;
  options.validation_every = 3;
  options.validation_samples = 4;
  options.checkpoint_every = 2;
  return options;
}

std::string trained(const RoutingTrainingOptions& options,
                    const std::filesystem::path& folder,
                    int stop_after = 0) {
  learner::TrainingRequest request;
  request.folder = folder;
  request.resume = true;
  request.keep_going = [&](int done, int, const std::string&) { return done != stop_after; };
  learner::run_training<RoutingTraining>(options, request);
  return read_file(folder / "checkpoint.safetensors");
}

constexpr int kHeldOut = 32;

/// How much of the way from the untaught network to what a long search finds the likeliest
/// allocations of held-out instances have come.
double share_learned(const std::string& estimator, int steps, int seed) {
  RoutingTrainingOptions options = small(estimator);
  options.seed = seed;
  options.steps = steps;
  options.batch = 8;
  options.samples = 4;
  options.rate = 1e-3;
  options.warm_up = 10;
  options.validation_samples = kHeldOut;
  RoutingTraining training(options);
  const double before = training.look().loss;
  while (!training.done()) training.step();
  const double after = training.look().loss;
  double searched = 0.0;
  for (int i = 0; i < kHeldOut; ++i) {
    SolveOptions search;
    search.agents = options.agents;
    search.time_s = 0.0;
    search.iterations = 3000;
    searched += solve(training.held_out(i), search, nullptr).longest() / kHeldOut;
  }
  return (before - after) / (before - searched);
}

TEST(RoutingTraining, InterruptedOrNotAndOnAnyNumberOfThreadsItEndsTheSame) {
  for (const char* estimator :
       {"constant_baseline", "sample_baseline", "control_variate", "alternating"}) {
    const testing::TempDir dir;
    const auto options = small(estimator);
    set_thread_count(1);
    const std::string whole = trained(options, dir.path() / "whole");
    set_thread_count(2);
    trained(options, dir.path() / "cut", 3);
    EXPECT_TRUE(whole == trained(options, dir.path() / "cut")) << estimator;
    set_thread_count(0);
  }
}

TEST(RoutingTraining, ShortensTheLongestTourOfInstancesThatItHasNotSeen) {
  for (const char* estimator : {"constant_baseline", "sample_baseline", "control_variate"}) {
    EXPECT_GT(share_learned(estimator, 150, 1), 0.6) << estimator;
  }
}

TEST(RoutingTraining, AlternatingNeedsFewStepsWhateverItStartsFrom) {
  for (const int seed : {1, 2, 3}) {
    EXPECT_GT(share_learned("alternating", 50, seed), 0.4) << "seed " << seed;
  }
}

TEST(RoutingTraining, ItsCardSaysWhatItWasTrainedOn) {
  const auto data = [](const std::string& estimator) {
    return RoutingTraining(small(estimator)).card().data;
  };
  EXPECT_EQ(data("sample_baseline"),
            "0 random instances of 10 to 14 uniform cities, depot random, estimator "
            "sample_baseline, 2 draws each");
  EXPECT_EQ(data("alternating"),
            "0 random instances of 10 to 14 uniform cities, depot random, estimator alternating, 5 "
            "iterations of its search per city");
}

TEST(RoutingTraining, ItsWeightsCanBeLoadedForAsManyAgentsOnly) {
  const testing::TempDir dir;
  trained(small("control_variate"), dir.path());
  const std::string file = (dir.path() / "allocation_network_3.safetensors").string();
  EXPECT_EQ(load_network(3, file)->agents, 3);
  EXPECT_THROW(load_network(4, file), InputError);
  EXPECT_THROW(load_network(77, ""), InputError);  // none is shipped
}

TEST(ShippedWeights, AreThereForFiveTenAndFifteenAgents) {
  EXPECT_EQ(shipped_agents(), (std::vector<int>{5, 10, 15}));
  for (const int agents : shipped_agents()) EXPECT_EQ(load_network(agents, "")->agents, agents);
}

TEST(RoutingTraining, RefusesOptionsThatMakeNoSense) {
  RoutingTrainingOptions options = small("sample_baseline");
  options.samples = 1;
  EXPECT_THROW(options.validate(), InputError);
  options = small("control_variate");
  options.agents = 0;
  EXPECT_THROW(options.validate(), InputError);
}

TEST(VarianceStudy, TheConstantBaselineScattersMost) {
  VarianceStudyOptions options;
  options.agents = 3;
  options.cities = 10;
  options.steps = 1;
  options.every = 2;
  const auto rows = variance_study(options, [](int, int) {});
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_GT(rows[0].constant_baseline, rows[0].sample_baseline);
  EXPECT_GT(rows[0].control_variate, 0.0);
  EXPECT_NE(variance_svg(options, rows).find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace imslam::routing
