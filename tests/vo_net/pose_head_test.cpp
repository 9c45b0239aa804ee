#include "vo_net/pose_head.hpp"

#include <gtest/gtest.h>

#include "slam/nn/ops/layout.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/vo_net/synthetic_points.hpp"
#include "vo_net/derotation.hpp"
#include "vo_net/flow_grid.hpp"
#include "vo_net/pose_head_loss.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Tensor;
using nn::Var;

PoseHeadSizes tiny_sizes(int passes) { return {4, 4, 4, 6, passes}; }

Correspondences points_of(const StereoCamera& camera, int count = 300) {
  Random random(5);
  return testing::synthetic_correspondences(camera, testing::test_motion(), count, {}, random);
}

Tensor<double> grid_of(const Correspondences& points, const StereoCamera& camera) {
  Tensor<float> grid = FlowGrid::make(1);
  FlowGrid::fill(points, camera, 0, grid);
  return nn::cast<double>(grid);
}

const float* cell_at(const Tensor<float>& grid, Index row, Index column) {
  return grid.data() + (row * FlowGrid::kColumns + column) * FlowGrid::kChannels;
}

TEST(FlowGrid, ACellHoldsTheWeightedMeanOfItsPointsAtTheirPlace) {
  const StereoCamera camera = testing::test_camera();
  Correspondence a;
  a.left0 = {100.0, 50.0};
  a.left1 = {103.0, 50.0};
  a.weight = 0.25;
  Correspondence b = a;
  b.left0 = {102.0, 52.0};
  b.left1 = {103.0, 56.0};
  b.weight = 0.5;
  Correspondence broken = a;
  broken.left1.x() = std::nan("");
  Tensor<float> grid = FlowGrid::make(2);
  FlowGrid::fill({a, b, broken}, camera, 1, grid);
  const float* const cell = cell_at(grid, FlowGrid::kRows + 3, 6);  // of the second sample
  EXPECT_NEAR(cell[FlowGrid::kFlowX], (3.0 + 2.0 * 1.0) / 3.0 / camera.fx, 1e-7);
  EXPECT_NEAR(cell[FlowGrid::kFlowY], 2.0 * 4.0 / 3.0 / camera.fy, 1e-7);
  EXPECT_FLOAT_EQ(cell[FlowGrid::kConfidence], 0.75F);
  EXPECT_NEAR(cell[FlowGrid::kPlaceX], ((100.0 + 2.0 * 102.0) / 3.0 - camera.cx) / camera.fx, 1e-6);
  const float* const empty = cell_at(grid, FlowGrid::kRows, 0);
  EXPECT_EQ(empty[FlowGrid::kConfidence], 0.0F);
  EXPECT_EQ(empty[FlowGrid::kFlowX], 0.0F);
  EXPECT_NEAR(empty[FlowGrid::kPlaceX], (752.0 / 96.0 - 0.5 - camera.cx) / camera.fx, 1e-6);
}

TEST(FlowGrid, AnotherResolutionOfTheSameViewIsTheSameGrid) {
  const StereoCamera camera = testing::test_camera();
  const Correspondences points = points_of(camera);
  const auto doubled = [](double x) { return 2.0 * x + 0.5; };  // the centre of pixel 0 is at 0
  StereoCamera fine = camera;
  fine.width *= 2;
  fine.height *= 2;
  fine.fx *= 2.0;
  fine.fy *= 2.0;
  fine.cx = doubled(camera.cx);
  fine.cy = doubled(camera.cy);
  Correspondences fine_points = points;
  for (Correspondence& c : fine_points) {
    c.left0 = c.left0.unaryExpr(doubled);
    c.left1 = c.left1.unaryExpr(doubled);
  }
  EXPECT_LT((grid_of(points, camera).array() - grid_of(fine_points, fine).array()).abs().maxCoeff(),
            1e-6);
}

/// Places, confidence and flow of a small field with a hole.
struct Field {
  Field() {
    Random random(9);
    for (Index i = 0; i < 8; ++i) {
      confidence[i] = i == 3 ? 0.0 : 1.0;
      for (Index k = 2 * i; k < 2 * i + 2; ++k) {
        place[k] = random.uniform(-0.7, 0.7);
        flow[k] = random.uniform(-0.1, 0.1);
      }
    }
  }
  Tensor<double> place{nn::Shape{2, 2, 2, 2}};
  Tensor<double> flow{nn::Shape{2, 2, 2, 2}};
  Tensor<double> confidence{nn::Shape{2, 2, 2, 1}};
};

TEST(Derotation, LeavesNothingOfAPureRotation) {
  Field field;
  const Eigen::Vector3d theta(0.05, -0.1, 0.2);
  const Eigen::Matrix3d R_left1_left0 = lie::SO3d::exp(-theta).matrix();
  for (Index i = 0; i < 8; ++i) {
    const Eigen::Vector3d turned =
        R_left1_left0 * Eigen::Vector3d(field.place[2 * i], field.place[2 * i + 1], 1.0);
    field.flow[2 * i] = turned.x() / turned.z() - field.place[2 * i];
    field.flow[2 * i + 1] = turned.y() / turned.z() - field.place[2 * i + 1];
  }
  nn::Tape<double> tape;
  const Tensor<double> angles({2, 3},
                              {theta.x(), theta.y(), theta.z(), theta.x(), theta.y(), theta.z()});
  const Var left = derotate(tape, tape.constant(field.flow), tape.constant(field.place),
                            tape.constant(field.confidence), tape.constant(angles));
  EXPECT_LT(tape.array(left).abs().maxCoeff(), 1e-15);
}

/// dL/dx of L = sum of random numbers times f(x), on the tape and by differences.
template <typename F>
void expect_gradient(const F& f, const Eigen::VectorXd& x) {
  const auto run = [&](const Eigen::VectorXd& at, Eigen::VectorXd* gradient) {
    nn::Tape<double> tape;
    Tensor<double> numbers({at.size()});
    numbers.array() = at.array();
    const Var input = tape.input(numbers);
    const Var y = f(tape, input);
    Tensor<double> seed(tape.shape(y));
    Random random(4);
    for (Index i = 0; i < seed.size(); ++i) seed[i] = random.normal();
    const double loss = (tape.array(y) * seed.array()).sum();
    if (gradient != nullptr) {
      tape.backward(y, seed);
      *gradient = tape.gradient(input);
    }
    return loss;
  };
  Eigen::VectorXd gradient(x.size());
  run(x, &gradient);
  const auto loss = [&](const Eigen::VectorXd& at) {
    return Eigen::VectorXd::Constant(1, run(at, nullptr));
  };
  testing::expect_near(gradient.transpose(), testing::numeric_jacobian(loss, x, 1e-6), 1e-7);
}

TEST(Derotation, GradientsMatchCentralDifferences) {
  const Field field;
  Eigen::VectorXd x(22);
  x << field.flow.array().matrix(), 0.1, -0.2, 0.15, 0.0, 0.3, -0.1;
  expect_gradient(
      [&](nn::Tape<double>& tape, Var input) {
        const Var flow = reshape(tape, slice(tape, input, 0, 0, 16), {2, 2, 2, 2});
        const Var theta = reshape(tape, slice(tape, input, 0, 16, 6), {2, 3});
        return derotate(tape, flow, tape.constant(field.place), tape.constant(field.confidence),
                        theta);
      },
      x);
}

TEST(Derotation, ComposedRotationsAndTheirGradientsAreRight) {
  Eigen::VectorXd x(12);
  x << 0.1, -0.2, 0.3, 1e-7, 0.0, 0.0, -0.05, 0.2, 0.1, 0.4, -0.3, 0.2;
  const auto both = [](nn::Tape<double>& tape, Var input) {
    return compose_rotations(tape, reshape(tape, slice(tape, input, 0, 0, 6), {2, 3}),
                             reshape(tape, slice(tape, input, 0, 6, 6), {2, 3}));
  };
  expect_gradient(both, x);
  nn::Tape<double> tape;
  Tensor<double> numbers({12});
  numbers.array() = x.array();
  const Var y = both(tape, tape.constant(numbers));
  const lie::SO3d expected = lie::SO3d::exp(x.segment<3>(6)) * lie::SO3d::exp(x.segment<3>(0));
  EXPECT_LT(
      (expected.log() - Eigen::Vector3d(tape.data(y)[0], tape.data(y)[1], tape.data(y)[2])).norm(),
      1e-14);
}

TEST(Derotation, TheMedianLengthIgnoresEmptyCellsAndHasAGradient) {
  const Field field;
  expect_gradient(
      [&](nn::Tape<double>& tape, Var input) {
        return median_length(tape, reshape(tape, input, {2, 2, 2, 2}),
                             tape.constant(field.confidence));
      },
      field.flow.array().matrix());
  nn::Tape<double> tape;
  const Var none =
      median_length(tape, tape.constant(field.flow), tape.constant(Tensor<double>({2, 2, 2, 1})));
  EXPECT_DOUBLE_EQ(tape.data(none)[0], 1e-6);
}

TEST(PoseHead, TwiceTheFlowIsTwiceTheRotationInTheSameDirection) {
  Random random(2);
  const PoseHead<double> head(tiny_sizes(1), random);
  const StereoCamera camera = testing::test_camera();
  Tensor<double> grid = grid_of(points_of(camera), camera);
  nn::Tape<double> tape(nn::Mode::kInference);
  const PoseHeadOutput once = head.forward(tape, tape.constant(grid)).back();
  for (Index i = 0; i < grid.size(); i += FlowGrid::kChannels) {
    grid[i + FlowGrid::kFlowX] *= 2.0;
    grid[i + FlowGrid::kFlowY] *= 2.0;
  }
  const PoseHeadOutput twice = head.forward(tape, tape.constant(grid)).back();
  EXPECT_LT((2.0 * tape.array(once.rotation) - tape.array(twice.rotation)).abs().maxCoeff(), 1e-8);
  EXPECT_LT((tape.array(once.direction) - tape.array(twice.direction)).abs().maxCoeff(), 1e-8);
  EXPECT_NEAR(tape.array(once.direction).matrix().norm(), 1.0, 1e-6);
}

TEST(PoseHead, GradientsOfTheLossMatchCentralDifferencesThroughAllLooks) {
  Random random(2);
  PoseHead<double> head(tiny_sizes(2), random);
  nn::ParameterList<double> parameters;
  head.collect(parameters);
  // Of empty cells an untrained network's rectifiers see nothing but biases of zero: a kink.
  for (std::size_t p = 0; p < parameters.count(); ++p) {
    for (double& value : parameters[p].value.array()) value += 0.1 * random.normal();
  }
  const StereoCamera camera = testing::test_camera();
  const Tensor<double> grid = grid_of(points_of(camera), camera);
  PoseHeadTruth<double> truth{Tensor<double>({1, 3}, {0.02, -0.01, 0.03}),
                              Tensor<double>({1, 3}, {0.6, 0.0, 0.8}),
                              Tensor<double>({1, 1}, {1.0})};
  const auto loss_of = [&](nn::Tape<double>& tape) {
    return pose_head_loss(tape, head.forward(tape, tape.constant(grid)), truth, 0.3);
  };
  nn::Tape<double> tape;
  tape.backward(loss_of(tape));
  nn::Gradients<double> gradients = nn::zero_gradients(parameters);
  tape.add_gradients_to(parameters, gradients);
  for (std::size_t p = 0; p < parameters.count(); ++p) {
    Tensor<double>& value = parameters[p].value;
    for (const Index i : {Index(0), value.size() / 2, value.size() - 1}) {
      const double before = value[i];
      const auto at = [&](double x) {
        value[i] = x;
        nn::Tape<double> trial(nn::Mode::kInference);
        return trial.number(loss_of(trial));
      };
      const double slope = (at(before + 1e-6) - at(before - 1e-6)) / 2e-6;
      value[i] = before;
      EXPECT_NEAR(gradients[p][i], slope, 1e-5 * std::max(1.0, std::abs(slope)))
          << parameters[p].name << " " << i;
    }
  }
}

TEST(PoseHead, AnEmptyGridGivesFiniteNumbers) {
  Random random(2);
  const PoseHead<float> head(PoseHeadSizes(), random);
  nn::Tape<float> tape(nn::Mode::kInference);
  Tensor<float> grid = FlowGrid::make(1);
  FlowGrid::fill({}, testing::test_camera(), 0, grid);
  const PoseHeadOutput answer = head.forward(tape, tape.constant(grid)).back();
  for (const Var v :
       {answer.rotation, answer.direction, answer.log_sigma_rotation, answer.log_sigma_direction}) {
    EXPECT_TRUE(tape.array(v).isFinite().all());
  }
}

}  // namespace
}  // namespace imslam::vo
