#include "datasets/simulation/paths.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam::simulation {
namespace {

PlanarLoop rounded_square() {
  PlanarLoop::Limits limits;
  limits.speed = 2.0;
  limits.turn_rate = 0.8;
  limits.lateral_accel = 1.0;
  limits.smoothing_m = 2.0;
  return PlanarLoop({{0, 0}, {20, 0}, {20, 20}, {0, 20}}, limits);
}

TEST(PlanarLoop, KeepsToItsLimits) {
  const PlanarLoop loop = rounded_square();
  const double h = 0.05;
  for (double t = h; t < loop.lap_time() - h; t += h) {
    const auto before = loop.at_time(t - h);
    const auto after = loop.at_time(t + h);
    const double speed = (after.position - before.position).norm() / (2 * h);
    const double turn = (after.yaw - before.yaw) / (2 * h);
    EXPECT_LE(speed, 2.0 + 1e-6);
    EXPECT_LE(std::abs(turn), 0.8 * 1.02);
    EXPECT_LE(std::abs(turn) * speed, 1.0 * 1.05);
  }
}

TEST(PlanarLoop, GoesRoundAgainWithoutAJump) {
  const PlanarLoop loop = rounded_square();
  const auto first = loop.at_time(3.0);
  const auto second = loop.at_time(3.0 + loop.lap_time());
  EXPECT_LT((first.position - second.position).norm(), 1e-9);
  EXPECT_NEAR(second.yaw - first.yaw, 2 * M_PI, 1e-9);
  EXPECT_NEAR(second.distance - first.distance, loop.length(), 1e-9);
  const auto end = loop.at_time(loop.lap_time() - 1e-6);
  const auto start = loop.at_time(loop.lap_time() + 1e-6);
  EXPECT_LT((end.position - start.position).norm(), 1e-4);
  EXPECT_NEAR(end.yaw, start.yaw, 1e-4);
}

TEST(PlanarLoop, KnowsHowFarAPlaceIs) {
  const PlanarLoop loop = rounded_square();
  EXPECT_NEAR(loop.clearance({10, 3}), 3.0, 1e-2);
  EXPECT_NEAR(loop.clearance({10, 10}), 10.0, 1e-1);
}

TEST(Wobble, StaysWithinItsAmplitude) {
  Random random(3);
  const Wobble wobble(random, 0.3, 0.1, 1.0);
  double largest = 0.0;
  for (double t = 0.0; t < 300.0; t += 0.05) largest = std::max(largest, std::abs(wobble(t)));
  EXPECT_LE(largest, 0.3);
  EXPECT_GT(largest, 0.1);
}

}  // namespace
}  // namespace imslam::simulation
