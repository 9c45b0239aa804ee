#include "vo_net/scale_corrector.hpp"

#include <gtest/gtest.h>

#include "tests/support/numeric_jacobian.hpp"
#include "tests/vo_net/synthetic_points.hpp"
#include "vo_net/scale_operation.hpp"

namespace imslam::vo {
namespace {

using Eigen::Vector3d;
using testing::PointNoise;

lie::SE3d left_motion(const StereoCamera& camera, const lie::SE3d& T_body0_body1) {
  return camera.T_body_left.inverse() * T_body0_body1 * camera.T_body_left;
}

MotionDirection direction_of(const lie::SE3d& T_left0_left1) {
  return {T_left0_left1.rotation(), T_left0_left1.translation().normalized()};
}

/// Correspondences of test_motion() and what a perfect pose head would say of it.
struct Scene {
  explicit Scene(const PointNoise& noise, int count = 200, std::uint64_t seed = 3) : random(seed) {
    points =
        testing::synthetic_correspondences(camera, testing::test_motion(), count, noise, random);
  }

  StereoCamera camera = testing::test_camera();
  Random random;
  Correspondences points;
  lie::SE3d T_left0_left1 = left_motion(camera, testing::test_motion());
  MotionDirection motion = direction_of(T_left0_left1);
  double length = T_left0_left1.translation().norm();
};

/// A third of the points somewhere else.
void spoil(Scene& scene) {
  for (std::size_t k = 0; k < scene.points.size(); ++k) {
    if (k % 10 >= 3) continue;
    scene.points[k].left1 +=
        Eigen::Vector2d{scene.random.uniform(-60.0, 60.0), scene.random.uniform(-60.0, 60.0)};
  }
}

TEST(ScaleCorrector, IsExactWithoutNoise) {
  const Scene scene({});
  const ScaleResult result = correct_scale(scene.points, scene.camera, scene.motion, {});
  EXPECT_EQ(result.state, ScaleState::kMoving);
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.scale, scene.length, 1e-9 * scene.length);
  EXPECT_EQ(result.inliers, 200);
}

TEST(ScaleCorrector, AConstantDisparityOffsetIsTakenAway) {
  PointNoise noise;
  noise.offset = 0.7;
  const Scene scene(noise);
  const ScaleResult result = correct_scale(scene.points, scene.camera, scene.motion, {}, 0.7);
  EXPECT_NEAR(result.scale, scene.length, 1e-9 * scene.length);
}

TEST(ScaleCorrector, BearsThirtyPercentOutliers) {
  PointNoise noise;
  noise.flow = 0.1;
  noise.disparity = 0.1;
  Scene scene(noise, 400);
  spoil(scene);
  const ScaleResult result = correct_scale(scene.points, scene.camera, scene.motion, {});
  EXPECT_EQ(result.state, ScaleState::kMoving);
  EXPECT_NEAR(result.scale, scene.length, 0.01 * scene.length);
  for (std::size_t k = 0; k < scene.points.size(); ++k) {
    if (k % 10 >= 3) {
      EXPECT_EQ(result.is_inlier[k], 1) << k;
    }
  }
}

TEST(ScaleCorrector, ItsSigmaIsThatOfItsErrors) {
  PointNoise noise;
  noise.flow = 0.2;
  noise.disparity = 0.2;
  double chi_squared = 0.0;
  constexpr int kTrials = 300;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Scene scene(noise, 100, static_cast<std::uint64_t>(trial));
    const ScaleResult result = correct_scale(scene.points, scene.camera, scene.motion, {});
    const double error = (result.scale - scene.length) / result.sigma;
    chi_squared += error * error / kTrials;
  }
  EXPECT_GT(chi_squared, 0.75);
  EXPECT_LT(chi_squared, 1.35);
}

TEST(ScaleCorrector, SeesThatTheCameraStandsStill) {
  Scene scene({});
  const lie::SE3d turn(scene.motion.R_left0_left1, Vector3d::Zero());
  PointNoise noise;
  noise.flow = 0.1;
  noise.disparity = 0.1;
  const lie::SE3d in_body = scene.camera.T_body_left * turn * scene.camera.T_body_left.inverse();
  scene.points =
      testing::synthetic_correspondences(scene.camera, in_body, 200, noise, scene.random);
  const ScaleResult result = correct_scale(scene.points, scene.camera, scene.motion, {});
  EXPECT_EQ(result.state, ScaleState::kStandingStill);
  EXPECT_EQ(result.scale, 0.0);
  EXPECT_LT(result.sigma, 2e-3);
  EXPECT_FALSE(scale_gradient(scene.points, scene.camera, scene.motion, {}, result).has_value());
}

TEST(ScaleCorrector, SaysThatTheDirectionIsTheWrongWayRound) {
  Scene scene({});
  scene.motion.direction = -scene.motion.direction;
  const ScaleResult result = correct_scale(scene.points, scene.camera, scene.motion, {});
  EXPECT_EQ(result.state, ScaleState::kBackwards);
  EXPECT_NEAR(result.scale, -scene.length, 1e-9);
}

TEST(ScaleCorrector, KnowsNothingWithoutUsablePoints) {
  Scene scene({}, 4);
  EXPECT_EQ(correct_scale({}, scene.camera, scene.motion, {}).state, ScaleState::kUnknown);
  scene.points[0].left1.x() = std::nan("");
  scene.points[1].disparity0 = 0.0;
  scene.points[2].weight = 0.0;
  scene.points[3].flow_information.setZero();
  EXPECT_EQ(correct_scale(scene.points, scene.camera, scene.motion, {}).state,
            ScaleState::kUnknown);
}

/// All numbers of one correspondence that have a gradient, in a row, and back.
Eigen::VectorXd numbers_of(const Correspondence& c) {
  Eigen::VectorXd x(10);
  x << c.left0, c.left1, c.disparity0, c.flow_information(0, 0), c.flow_information(0, 1),
      c.flow_information(1, 1), c.disparity0_information, c.weight;
  return x;
}

Correspondence with_numbers(Correspondence c, const Eigen::VectorXd& x) {
  c.left0 = x.segment<2>(0);
  c.left1 = x.segment<2>(2);
  c.disparity0 = x[4];
  c.flow_information << x[5], x[6], x[6], x[7];
  c.disparity0_information = x[8];
  c.weight = x[9];
  return c;
}

ScaleOptions fixed_noise() {
  ScaleOptions options;
  options.adapt_noise_scale = false;
  options.tolerance = 1e-13;
  options.max_rounds = 200;
  return options;
}

Scene noisy_scene() {
  PointNoise noise;
  noise.flow = 0.3;
  noise.disparity = 0.3;
  Scene scene(noise, 40);
  for (std::size_t k = 0; k < 6; ++k) scene.points[k].left1.x() += 3.0;  // beyond the kernel's bend
  for (Correspondence& c : scene.points) {
    c.weight = scene.random.uniform(0.3, 1.0);
    c.flow_information(0, 1) = c.flow_information(1, 0) = 0.3 * c.flow_information(0, 0);
  }
  return scene;
}

TEST(ScaleCorrector, GradientsOfThePointsMatchCentralDifferences) {
  const Scene scene = noisy_scene();
  const ScaleOptions options = fixed_noise();
  const ScaleResult result = correct_scale(scene.points, scene.camera, scene.motion, options);
  const auto gradients = scale_gradient(scene.points, scene.camera, scene.motion, options, result);
  ASSERT_TRUE(gradients.has_value());
  for (const std::size_t k : {0U, 3U, 10U, 25U}) {
    const auto scale_at = [&](const Eigen::VectorXd& x) {
      Correspondences moved = scene.points;
      moved[k] = with_numbers(moved[k], x);
      return Eigen::VectorXd::Constant(
          1, correct_scale(moved, scene.camera, scene.motion, options).scale);
    };
    const ScalePointGradient& g = (*gradients)[k];
    Eigen::MatrixXd actual(1, 10);
    actual << g.left0.transpose(), g.left1.transpose(), g.disparity0, g.flow_information(0, 0),
        2.0 * g.flow_information(0, 1), g.flow_information(1, 1), g.disparity0_information,
        g.weight;
    const Eigen::MatrixXd expected =
        testing::numeric_jacobian(scale_at, numbers_of(scene.points[k]), 1e-4);
    const double largest = expected.cwiseAbs().maxCoeff();
    testing::expect_near(actual / largest, expected / largest, 1e-5);
  }
}

TEST(ScaleCorrector, DerivativesOfTheMotionMatchCentralDifferences) {
  const Scene scene = noisy_scene();
  const ScaleOptions options = fixed_noise();
  const ScaleResult result = correct_scale(scene.points, scene.camera, scene.motion, options);
  const auto scale_at = [&](const Eigen::VectorXd& x) {
    const MotionDirection moved{scene.motion.R_left0_left1 * lie::SO3d::exp(x.segment<3>(0)),
                                scene.motion.direction + x.segment<3>(3)};
    return Eigen::VectorXd::Constant(
        1, correct_scale(scene.points, scene.camera, moved, options, x[6]).scale);
  };
  Eigen::MatrixXd actual(1, 7);
  actual << result.J_rotation.transpose(), result.J_direction.transpose(),
      result.J_disparity_offset;
  testing::expect_near(actual, testing::numeric_jacobian(scale_at, Eigen::VectorXd::Zero(7), 1e-7),
                       1e-6);
}

TEST(ScaleOperation, GradientsOnTheTapeMatchCentralDifferences) {
  const Scene scene = noisy_scene();
  const ScaleOptions options = fixed_noise();
  const Vector3d theta = scene.motion.R_left0_left1.log();
  const auto count = static_cast<nn::Index>(scene.points.size());
  Eigen::VectorXd x(6 + 3 * count);
  x.head<6>() << theta, scene.motion.direction;
  for (nn::Index k = 0; k < count; ++k) {
    const Correspondence& c = scene.points[static_cast<std::size_t>(k)];
    x.segment<3>(6 + 3 * k) << c.left1, c.disparity0;
  }
  const Vector3d seed(0.7, -0.4, 1.1);
  const auto run = [&](const Eigen::VectorXd& at, Eigen::VectorXd* gradient) {
    nn::Tape<double> tape;
    const auto input = [&](nn::Index first, const nn::Shape& shape) {
      nn::Tensor<double> numbers(shape);
      numbers.array() = at.segment(first, shape.size()).array();
      return tape.input(numbers);
    };
    const std::array<nn::Var, 3> inputs{input(0, {1, 3}), input(3, {1, 3}), input(6, {count, 3})};
    const nn::Var p = metric_translation(tape, inputs[0], inputs[1], inputs[2], scene.points,
                                         scene.camera, options);
    if (gradient != nullptr) {
      tape.backward(p, nn::Tensor<double>({1, 3}, {seed.x(), seed.y(), seed.z()}));
      *gradient << tape.gradient(inputs[0]), tape.gradient(inputs[1]), tape.gradient(inputs[2]);
    }
    return Vector3d(tape.data(p)[0], tape.data(p)[1], tape.data(p)[2]);
  };
  Eigen::VectorXd gradient(x.size());
  run(x, &gradient);
  const auto weighed = [&](const Eigen::VectorXd& at) {
    return Eigen::VectorXd::Constant(1, seed.dot(run(at, nullptr)));
  };
  testing::expect_near(gradient.transpose(), testing::numeric_jacobian(weighed, x, 1e-7), 1e-6);
}

}  // namespace
}  // namespace imslam::vo
