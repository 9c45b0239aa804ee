#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/command.hpp"

namespace imslam::testing {
namespace {

class RouteCommand : public ::testing::Test {
 protected:
  CommandResult route(const std::string& arguments) {
    return run_imslam(dir_, "route " + arguments);
  }
  std::string path(const std::string& name) const { return (dir_.path() / name).string(); }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(dir_.path() / name) << text;
  }
  TempDir dir_;
};

TEST_F(RouteCommand, SolvesAFileAndWritesTours) {
  write("cities.csv", "x,y\n0,0\n1,0\n1,1\n0,1\n-1,0\n");
  const std::string arguments = "solve " + quoted(path("cities.csv")) +
                                " --agents 2 --depot 1 --time 0 --iterations 500 --out " +
                                quoted(path("out"));
  const CommandResult result = route(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("longest"), std::string::npos);
  const auto json = nlohmann::json::parse(slurp(path("out/tours.json")));
  EXPECT_EQ(json.at("tours").size(), 2U);
  EXPECT_EQ(json.at("lengths").size(), 2U);
  EXPECT_EQ(json.at("depot"), 1);
  EXPECT_NE(slurp(path("out/tours.csv")).find("agent,stop,city"), std::string::npos);
  EXPECT_NE(slurp(path("out/tours.svg")).find("</svg>"), std::string::npos);
  const std::string first = slurp(path("out/tours.json"));
  EXPECT_EQ(route(arguments).exit_code, 6);  // not overwritten
  EXPECT_EQ(run_imslam(dir_, "--threads 2 route " + arguments + " --force").exit_code, 0);
  EXPECT_EQ(slurp(path("out/tours.json")), first);
}

TEST_F(RouteCommand, TakesTheShippedNetworkAndAnyOther) {
  EXPECT_EQ(route("solve --random 60 --agents 10 --method network").exit_code, 0);
  EXPECT_EQ(route("solve --random 60 --agents 7 --method network").exit_code, 5);
  const std::string train =
      "train --agents 2 --cities 8 --set steps=4 --set batch=2 --set "
      "validation_samples=2 --set warm_up=1 --set validation_every=2 --out " +
      quoted(path("training"));
  ASSERT_EQ(route(train).exit_code, 0);
  EXPECT_EQ(route(train).exit_code, 6);
  EXPECT_EQ(route(train + " --resume").exit_code, 0);
  EXPECT_EQ(route("solve --random 20 --agents 2 --method network_search --time 0.1 --weights " +
                  quoted(path("training/allocation_network_2.safetensors")))
                .exit_code,
            0);
}

TEST_F(RouteCommand, ComparesMethods) {
  const CommandResult result =
      route("bench --agents 3 --cities 20,30 --instances 2 --time 0.05 --out " +
            quoted(path("bench.csv")));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("lower bound"), std::string::npos);
  EXPECT_NE(slurp(path("bench.csv")).find("3,30,search 0.05 s,"), std::string::npos);
}

// Of whatever number of agents: a name mistyped must not cost the row in silence.
TEST_F(RouteCommand, WeightsToCompareMustBeThere) {
  for (const std::string& weights : {"RL=" + path("none_3.safetensors"),
                                     "RL=" + path("none_7.safetensors"), std::string("RL")}) {
    const CommandResult result = route(
        "bench --agents 3 --cities 20 --instances 1 --time 0.01 --weights " + quoted(weights));
    EXPECT_EQ(result.exit_code, 5) << weights;
    EXPECT_NE(result.err.find("--weights " + weights), std::string::npos) << result.err;
  }
}

TEST_F(RouteCommand, SaysWhatIsWrong) {
  EXPECT_EQ(route("solve --agents 2").exit_code, 2);
  EXPECT_EQ(route("solve --random 10").exit_code, 2);  // no agents
  EXPECT_EQ(route("solve --random 10 --agents 2 --depot 10").exit_code, 2);
  EXPECT_EQ(route("solve --random 10 --agents 0").exit_code, 2);
  EXPECT_EQ(route("solve " + quoted(path("none.csv")) + " --agents 2").exit_code, 3);
  write("bad.csv", "0,0\n1,nan\n");
  const CommandResult bad = route("solve " + quoted(path("bad.csv")) + " --agents 2");
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_NE(bad.err.find("bad.csv:2: a number is not finite"), std::string::npos);
  write("far.csv", "0,0\n1e39,1\n0,1\n");
  EXPECT_EQ(route("solve " + quoted(path("far.csv")) + " --agents 2").exit_code, 3);
  EXPECT_EQ(route("train --estimator guess").exit_code, 2);
  EXPECT_EQ(route("bench --cities x").exit_code, 2);
}

}  // namespace
}  // namespace imslam::testing
