#include "pgo/measurement_gradient.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/pgo/synthetic.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::pgo {
namespace {

using testing::random_covariance;
using testing::random_matrix;
using testing::Vector6;
using testing::Vector9;
using testing::wavy_states;

SolverOptions to_the_last_digit() {
  SolverOptions options;
  options.function_tolerance = 0.0;
  options.parameter_tolerance = 1e-15;
  options.gradient_tolerance = 1e-13;
  options.max_iterations = 30;
  return options;
}

/// A graph with skip edges whose noise makes every residual differ from zero, and one outlier far
/// out on the robust kernel. Unit-size sigmas keep all derivatives of order one.
PoseVelocityGraph noisy_graph() {
  Random random(77);
  const auto truth = wavy_states(8, 0.5);
  GraphOptions options;
  options.kernel_width = 2.0;
  options.gyro_random_walk = 0.01;
  options.accel_random_walk = 0.01;
  options.estimate_time_offset = true;
  options.estimate_disparity_offset = true;
  PoseVelocityGraph graph(options);
  for (const State& state : truth) graph.add_state(state);
  const auto add_visual = [&](int i, int j, double size) {
    RelativeMotion motion = testing::exact_visual_motion(truth[static_cast<std::size_t>(i)],
                                                         truth[static_cast<std::size_t>(j)]);
    motion.covariance = random_covariance<6>(random, 0.02);
    motion.J_disparity_offset = 0.01 * random_matrix<6, 1>(random);
    motion.T_body0_body1 =
        motion.T_body0_body1 * lie::SE3d::exp(size * random_matrix<6, 1>(random));
    EXPECT_TRUE(graph.add_visual_edge(i, j, motion));
  };
  for (int j = 1; j < 8; ++j) {
    add_visual(j - 1, j, j == 4 ? 0.2 : 0.02);
    if (j >= 3) add_visual(j - 3, j, 0.02);
    ImuMotion motion = testing::exact_imu_motion(truth[static_cast<std::size_t>(j - 1)],
                                                 truth[static_cast<std::size_t>(j)]);
    motion.covariance = random_covariance<9>(random, 0.02);
    motion.J_time_offset = 0.1 * random_matrix<9, 1>(random);
    motion.dR = motion.dR * lie::SO3d::exp(0.02 * random.normal3());
    motion.dv += 0.02 * random.normal3();
    motion.dp += 0.02 * random.normal3();
    EXPECT_TRUE(graph.add_imu_edge(j - 1, j, motion));
  }
  graph.anchor_position_and_heading(0, truth[0].nav.T_world_body);
  graph.add_bias_prior(0, {}, 0.05, 0.1);
  graph.add_time_offset_prior(0.0, 0.05);
  graph.add_disparity_offset_prior(0.0, 0.5);
  return graph;
}

double log_determinant_of(const Eigen::MatrixXd& covariance) {
  return std::log(covariance.determinant());
}

/// min over the states of the cost, after `change` of the measurements: the whole re-solve.
template <typename Change>
double solved_cost(PoseVelocityGraph graph, const Change& change) {
  change(graph);
  const SolveReport report = graph.solve(to_the_last_digit());
  EXPECT_LT(report.gradient_norm, 1e-4) << report.reason;
  return graph.cost();
}

class MeasurementGradientTest : public ::testing::Test {
 protected:
  void SetUp() override {
    graph_ = noisy_graph();
    graph_.solve(to_the_last_digit());
    gradient_ = measurement_gradient(graph_);
  }

  PoseVelocityGraph graph_;
  MeasurementGradient gradient_;
};

TEST_F(MeasurementGradientTest, VisualMotionMatchesCentralDifferencesThroughTheSolve) {
  for (std::size_t edge = 0; edge < graph_.visual_edges().size(); ++edge) {
    const RelativeMotion motion = graph_.visual_edges()[edge].motion;
    const auto cost = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
      return Eigen::VectorXd::Constant(1, solved_cost(graph_, [&](PoseVelocityGraph& graph) {
                                         RelativeMotion moved = motion;
                                         moved.T_body0_body1 =
                                             motion.T_body0_body1 * lie::SE3d::exp(step);
                                         ASSERT_TRUE(graph.set_visual_motion(edge, moved));
                                       }));
    };
    testing::expect_near(gradient_.visual[edge].motion.transpose(),
                         testing::numeric_jacobian(cost, Vector6::Zero(), 1e-5), 1e-6);
  }
}

TEST_F(MeasurementGradientTest, ImuMotionMatchesCentralDifferencesThroughTheSolve) {
  for (std::size_t edge = 0; edge < graph_.inertial_edges().size(); ++edge) {
    const ImuMotion motion = graph_.inertial_edges()[edge].motion;
    const auto cost = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
      return Eigen::VectorXd::Constant(1, solved_cost(graph_, [&](PoseVelocityGraph& graph) {
                                         ImuMotion moved = motion;
                                         moved.dR = motion.dR * lie::SO3d::exp(step.head<3>());
                                         moved.dv += step.segment<3>(3);
                                         moved.dp += step.tail<3>();
                                         ASSERT_TRUE(graph.set_imu_motion(edge, moved));
                                       }));
    };
    testing::expect_near(gradient_.inertial[edge].motion.transpose(),
                         testing::numeric_jacobian(cost, Vector9::Zero(), 1e-5), 1e-6);
  }
}

TEST_F(MeasurementGradientTest, CovarianceMatchesCentralDifferencesThroughTheSolve) {
  const MeasurementGradient with_log = measurement_gradient(graph_, true);
  Random random(5);
  for (std::size_t edge : {0UL, 3UL, 5UL}) {  // the fourth is the outlier
    const Eigen::Matrix<double, 6, 6> covariance = graph_.visual_edges()[edge].motion.covariance;
    const Eigen::Matrix<double, 6, 6> A = random_matrix<6, 6>(random);
    const Eigen::Matrix<double, 6, 6> direction = 1e-4 * (A + A.transpose());
    const auto moved = [&](double step) -> Eigen::Matrix<double, 6, 6> {
      return covariance + step * direction;
    };
    const auto cost = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
      return Eigen::VectorXd::Constant(1, solved_cost(graph_, [&](PoseVelocityGraph& graph) {
                                         RelativeMotion motion = graph.visual_edges()[edge].motion;
                                         motion.covariance = moved(step(0));
                                         ASSERT_TRUE(graph.set_visual_motion(edge, motion));
                                       }));
    };
    const double numeric = testing::numeric_jacobian(cost, Eigen::VectorXd::Zero(1), 1e-4)(0);
    const double analytic = gradient_.visual[edge].covariance.cwiseProduct(direction).sum();
    EXPECT_NEAR(analytic, numeric, 1e-6 * std::max(1.0, std::abs(numeric)));
    const double log_numeric =
        0.5 * (log_determinant_of(moved(1e-4)) - log_determinant_of(moved(-1e-4))) / 2e-4;
    EXPECT_NEAR(with_log.visual[edge].covariance.cwiseProduct(direction).sum() - analytic,
                log_numeric, 1e-5);
  }
}

TEST_F(MeasurementGradientTest, RobustKernelLimitsThePullOfAnOutlier) {
  // |dL/dz| <= kernel width / sigma for Huber, however far the measurement is.
  RelativeMotion outlier = graph_.visual_edges()[5].motion;
  outlier.covariance = 4e-4 * Eigen::Matrix<double, 6, 6>::Identity();
  outlier.T_body0_body1 = outlier.T_body0_body1 * lie::SE3d::exp(0.5 * Vector6::Ones());
  ASSERT_TRUE(graph_.set_visual_motion(5, outlier));
  graph_.solve(to_the_last_digit());
  const double pull = measurement_gradient(graph_).visual[5].motion.norm();
  EXPECT_LT(pull, 2.0 / 0.02 * 1.5);
  EXPECT_GT(pull, 2.0 / 0.02 * 0.5);
}

TEST_F(MeasurementGradientTest, BiasPriorMatchesCentralDifferencesOfTheLikelihoodThroughTheSolve) {
  const BiasPriorGradient gradient = measurement_gradient(graph_, true).bias_priors.at(0);
  const auto likelihood = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
    PoseVelocityGraph graph = graph_;
    BiasPrior& prior = graph.data().bias_priors[0];
    prior.bias.gyro += step.head<3>();
    prior.bias.accel += step.segment<3>(3);
    prior.sigma.gyro.array() *= step.segment<3>(6).array().exp();
    prior.sigma.accel.array() *= step.tail<3>().array().exp();
    graph.solve(to_the_last_digit());
    return Eigen::VectorXd::Constant(1, negative_log_likelihood(graph).total());
  };
  Eigen::RowVectorXd analytic(12);
  analytic << gradient.value.transpose(), gradient.log_sigma.transpose();
  testing::expect_near(
      analytic, testing::numeric_jacobian(likelihood, Eigen::VectorXd::Zero(12), 1e-5), 1e-6);
}

TEST_F(MeasurementGradientTest, LikelihoodIsTheCostAndTheLogDeterminants) {
  double expected = graph_.cost();
  for (const VisualEdge& edge : graph_.visual_edges()) {
    expected += 0.5 * log_determinant_of(edge.motion.covariance);
  }
  for (const InertialEdge& edge : graph_.inertial_edges()) {
    expected += 0.5 * log_determinant_of(edge.motion.covariance);
  }
  for (const BiasPrior& prior : graph_.data().bias_priors) {
    expected += prior.sigma.gyro.array().log().sum() + prior.sigma.accel.array().log().sum();
  }
  const NegativeLogLikelihood parts = negative_log_likelihood(graph_);
  EXPECT_NEAR(parts.total(), expected, 1e-9 * std::abs(expected));
  EXPECT_EQ(parts.visual.size(), graph_.visual_edges().size());
  EXPECT_EQ(parts.inertial.size(), graph_.inertial_edges().size());
  EXPECT_GT(parts.rest, 0.0);  // walks of the bias, the other priors
}

}  // namespace
}  // namespace imslam::pgo
