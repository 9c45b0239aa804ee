#include "vo_net/regression_cost.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/vo_net/synthetic_points.hpp"
#include "vo_net/pose_head_weights.hpp"

namespace imslam::vo {
namespace {

using testing::synthetic_correspondences;
using testing::test_camera;
using testing::test_motion;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// The shipped pose head in double.
PoseHead<double> shipped() {
  Random random(1);
  PoseHead<double> network(PoseHeadSizes(), random);
  PoseHead<float> single = *load_pose_head("").network;
  nn::ParameterList<float> from;
  nn::ParameterList<double> to;
  single.collect(from);
  network.collect(to);
  nn::copy_values<double>(from, to);
  return network;
}

/// U = 1/2 |Log(T_wanted^-1 T)|^2 in units of centimetres and milliradians, whatever the
/// covariance.
MotionSlope distance(const RelativeMotion& motion, const lie::SE3d& T_wanted) {
  const Vector6 weight = (Vector6() << 1e2, 1e2, 1e2, 1e3, 1e3, 1e3).finished();
  const auto cost = [&](const lie::SE3d& T) {
    return 0.5 * weight.cwiseProduct((T_wanted.inverse() * T).log()).squaredNorm();
  };
  MotionSlope slope{cost(motion.T_body0_body1), Vector6::Zero(), Matrix6::Zero()};
  for (int k = 0; k < 6; ++k) {
    const Vector6 h = 1e-6 * Vector6::Unit(k);
    slope.by_motion[k] = (cost(motion.T_body0_body1 * lie::SE3d::exp(h)) -
                          cost(motion.T_body0_body1 * lie::SE3d::exp(-h))) /
                         2e-6;
  }
  return slope;
}

TEST(RegressionCost, SlopesByParametersMatchCentralDifferencesThroughTheScale) {
  PoseHead<double> network = shipped();
  nn::ParameterList<double> parameters;
  network.collect(parameters);
  Random random(3);
  MotionRecipe recipe;
  recipe.camera = test_camera();
  const Correspondences points =
      synthetic_correspondences(recipe.camera, test_motion(), 400, {0.2, 0.2, 0.0}, random);
  ScaleOptions options;
  options.adapt_noise_scale = false;  // it counts as a constant
  options.max_rounds = 300;           // nearly all points lie beyond the kernel's bend then
  const auto cost = [&](nn::Gradients<double>* gradients) {
    nn::Tape<double> tape;
    const auto motion =
        regression_cost<double>(tape, network, points, recipe, options, {},
                                [](const RelativeMotion& m) { return distance(m, lie::SE3d()); });
    EXPECT_TRUE(motion.usable);
    if (gradients != nullptr) {
      tape.backward(motion.cost);
      tape.add_gradients_to(parameters, *gradients);
    }
    return tape.number(motion.cost);
  };
  nn::Gradients<double> gradients = nn::zero_gradients(parameters);
  cost(&gradients);
  const double typical = nn::Tensor<double>(gradients.back()).array().abs().maxCoeff();
  int checked = 0;
  for (int draw = 0; checked < 12 && draw < 400; ++draw) {
    const auto place = static_cast<std::size_t>(
        random.integer(0, static_cast<std::int64_t>(parameters.count()) - 1));
    nn::Parameter<double>& parameter = parameters[place];
    const nn::Index i = random.integer(0, parameter.value.size() - 1);
    if (std::abs(gradients[place][i]) < 1e-3 * typical) continue;
    const double value = parameter.value[i];
    const double h = 1e-6 * std::max(0.1, std::abs(value));
    parameter.value[i] = value + h;
    const double above = cost(nullptr);
    parameter.value[i] = value - h;
    const double below = cost(nullptr);
    parameter.value[i] = value;
    const double slope = (above - below) / (2.0 * h);
    EXPECT_NEAR(gradients[place][i], slope, 1e-3 * std::abs(slope)) << parameter.name << " " << i;
    ++checked;
  }
  EXPECT_EQ(checked, 12);
}

}  // namespace
}  // namespace imslam::vo
