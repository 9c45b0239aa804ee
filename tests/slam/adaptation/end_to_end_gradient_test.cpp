#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "imu_net/edge_noise_cost.hpp"
#include "imu_net/imu_corrector.hpp"
#include "imu_net/imu_weights.hpp"
#include "pgo/edge_likelihood.hpp"
#include "pgo/whitening.hpp"
#include "slam/base/error.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "tests/vo_net/synthetic_images.hpp"
#include "vo_net/learned_matcher.hpp"
#include "vo_net/match_weights.hpp"
#include "vo_net/motion_cost.hpp"
#include "vo_net/motion_noise.hpp"
#include "vo_net/visual_odometry.hpp"

// dU/dtheta through matcher, pose layer, preintegration and the converged graph, in double, against
// central differences of U through the whole of it. U = L with its normalisation:
//
//   U(theta) = min over states of L(states, z(theta)) + 1/2 sum log det Sigma(theta)

namespace imslam::adaptation {
namespace {

using nn::Var;
using testing::PlaneWorld;
using testing::pose_of_frame;
using testing::small_camera;

constexpr int kFrames = 3;

pgo::SolverOptions to_the_last_digit() {
  pgo::SolverOptions options;
  options.function_tolerance = 0.0;
  options.parameter_tolerance = 1e-16;
  options.gradient_tolerance = 1e-11;
  options.max_iterations = 100;
  return options;
}

/// The shipped networks in double, a few frames of a plane, readings of the motion.
class World {
 public:
  World() {
    shipped_ = vo::load_match_network("", vo::MatchUse::kTraining).network;
    Random random(3);
    match_ = std::make_unique<vo::MatchNetwork<double>>(vo::MatchNetworkOptions(), random);
    nn::ParameterList<float> from;
    shipped_->collect(from);
    nn::ParameterList<double> match_parameters;
    match_->collect(match_parameters);
    nn::copy_values<double>(from, match_parameters);
    match_->freeze_norms(true);

    const auto said = imu::load_imu_network("").network;
    auto own = *said;
    nn::ParameterList<float> from_imu;
    own.collect(from_imu);
    imu_ = std::make_unique<imu::ImuNetwork<double>>(imu::ImuNetworkSizes(), random);
    nn::ParameterList<double> imu_parameters;
    imu_->collect(imu_parameters);
    nn::copy_values<double>(from_imu, imu_parameters);

    noise_ = std::make_unique<vo::MotionNoise<double>>(random);
    nn::ParameterList<double> noise_parameters;
    noise_->collect(noise_parameters);
    for (nn::Parameter<double>* parameter : noise_parameters) {
      for (nn::Index i = 0; i < parameter->value.size(); ++i) {
        parameter->value[i] = random.uniform(-0.3, 0.3);
      }
    }
    match_->collect(parameters_, "match/");
    noise_->collect(parameters_, "noise/");
    imu_->collect(parameters_, "imu/");
    see();
    sense(random);
  }

  /// U; if asked its gradient by all parameters.
  double upper_cost(nn::Gradients<double>* gradients = nullptr) {
    nn::Tape<double> tape;
    const imu::ImuAnswer answer = imu_->forward(tape, frames_, imu_->gru.zero_state(tape, 3));
    std::vector<vo::ReplayedMatch> matches;
    std::vector<Var> noises;
    for (std::size_t i = 0; i < recorded_.size(); ++i) {
      matches.push_back(vo::replay_match(tape, *match_, images(i), recorded_[i].correspondences));
      const Var features = tape.make({1, vo::MotionNoiseFeatures::kCount});
      std::copy(features_[i].values.begin(), features_[i].values.end(), tape.data(features));
      noises.push_back(noise_->forward(tape, features));
    }
    const pgo::PoseVelocityGraph graph = solved_graph(tape, matches, noises, answer);
    if (gradients != nullptr) {
      tape.backward(lessons(tape, graph, matches, noises, answer));
      tape.add_gradients_to(parameters_, *gradients);
    }
    return cost_of(graph);
  }

  const nn::ParameterList<double>& parameters() const { return parameters_; }
  const SolveReport& report() const { return report_; }

 private:
  struct Recorded {
    vo::Correspondences correspondences;
    vo::MatchSearch search;
    vo::PoseLayerResult pose;
  };

  vo::ReplayImages images(std::size_t i) const {
    return {&stereo_[i].left, &stereo_[i].right, &stereo_[i + 1].left, &stereo_[i + 1].right,
            recorded_[i].search};
  }

  /// What the odometry saw, every number the network's own.
  void see() {
    vo::VoOptions options;
    options.learned.polish = false;
    options.learned.max_points = 60;
    options.pose = pose_options_;
    auto folded = std::make_shared<vo::MatchNetwork<float>>(*shipped_);
    folded->fold();
    vo::VisualOdometry odometry(
        options, camera_, std::make_unique<vo::LearnedMatcher>(options.learned, camera_, folded));
    const PlaneWorld plane(5);
    for (int i = 0; i < kFrames; ++i) {
      stereo_.push_back(plane.draw(camera_, pose_of_frame(i), time_ns(i)));
      const vo::VoOutput seen = odometry.process(stereo_.back());
      if (i == 0) continue;
      expects(seen.motion.valid, "the world of the test cannot be seen");
      recorded_.push_back({seen.correspondences, seen.search, seen.pose});
      covariances_.push_back(seen.motion.covariance);
      features_.push_back(vo::motion_noise_features(seen.pose, seen.correspondences, camera_));
    }
  }

  static std::int64_t time_ns(int frame) { return 2'000'000'000 + 50'000'000LL * frame; }

  /// Readings of a body that shakes, with two seconds before the first frame.
  void sense(Random& random) {
    for (int i = 0; i < 480; ++i) {
      ImuSample sample;
      sample.time_ns = 5'000'000LL * i;
      const double t = 0.005 * i;
      sample.angular_velocity =
          0.3 * Eigen::Vector3d(std::sin(3 * t), std::cos(2 * t), 0.4) + 0.01 * random.normal3();
      sample.linear_acceleration =
          Eigen::Vector3d(0.5 * std::sin(5 * t), 0.3, 9.7) + 0.05 * random.normal3();
      samples_.push_back(sample);
    }
    noise_model_.gyro_noise_density = 2e-3;
    noise_model_.accel_noise_density = 2e-2;
    imu::FeatureExtractor extractor(noise_model_);
    std::vector<imu::ImuFrame> frames;
    for (const ImuSample& sample : samples_) {
      for (const imu::ImuFrame& frame : extractor.add(sample)) {
        frames.push_back(frame);
        frame_times_.push_back(frame.time_ns);
      }
    }
    frames_ = imu::frame_tensors<double>(frames, noise_model_);
  }

  /// The motion of the odometry with the networks as they are on the tape.
  RelativeMotion motion_of(nn::Tape<double>& tape,
                           std::size_t i,
                           const vo::ReplayedMatch& match,
                           Var noise) const {
    const auto now = vo::replayed(tape, match, recorded_[i].correspondences, 0.05);
    const auto pose = vo::solve_pose(now, camera_, pose_options_, recorded_[i].pose.T_body0_body1);
    RelativeMotion motion;
    motion.T_body0_body1 = pose.T_body0_body1;
    const auto F = vo::noise_factors(tape.data(noise)[0], tape.data(noise)[1]);
    motion.covariance = F.asDiagonal() * covariances_[i] * F.asDiagonal();
    motion.valid = pose.valid;
    return motion;
  }

  std::vector<ImuMotion> integrated(nn::Tape<double>& tape, const imu::ImuAnswer& answer) {
    std::vector<ImuMotion> motions;
    imu::EdgeNoiseTask task = edge_task([&](std::size_t, const ImuMotion& motion) {
      motions.push_back(motion);
      return imu::CovarianceSlope{0.0, Eigen::Matrix<double, 9, 9>::Zero()};
    });
    edge_noise_cost(tape, answer, task);
    return motions;
  }

  template <typename Cost>
  imu::EdgeNoiseTask edge_task(const Cost& cost) {
    imu::EdgeNoiseTask task;
    task.samples = &samples_;
    task.datasheet = task.base = noise_model_;
    task.frame_times = frame_times_;
    for (std::size_t i = 0; i + 1 < kFrames; ++i) {
      task.edges.push_back({time_ns(static_cast<int>(i)),
                            time_ns(static_cast<int>(i) + 1),
                            {},
                            0.0,
                            [=](const ImuMotion& m) { return cost(i, m); }});
    }
    return task;
  }

  pgo::PoseVelocityGraph solved_graph(nn::Tape<double>& tape,
                                      const std::vector<vo::ReplayedMatch>& matches,
                                      const std::vector<Var>& noises,
                                      const imu::ImuAnswer& answer) {
    pgo::PoseVelocityGraph graph;
    lie::SE3d pose;
    for (int i = 0; i < kFrames; ++i) {
      graph.add_state({time_ns(i), {pose, Eigen::Vector3d::Zero()}, {}});
    }
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const auto from = static_cast<int>(i);
      graph.add_visual_edge(from, from + 1, motion_of(tape, i, matches[i], noises[i]));
    }
    const auto motions = integrated(tape, answer);
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const auto from = static_cast<int>(i);
      graph.add_imu_edge(from, from + 1, motions[i]);
    }
    graph.anchor_position_and_heading(0, pose);
    graph.add_bias_prior(0, {}, 0.05, 0.3);
    report_ = graph.solve(to_the_last_digit());
    return graph;
  }

  static double cost_of(const pgo::PoseVelocityGraph& graph) {
    double cost = graph.cost();
    for (const auto& edge : graph.visual_edges()) cost += half_log_det(edge.motion.covariance);
    for (const auto& edge : graph.inertial_edges()) cost += half_log_det(edge.motion.covariance);
    return cost;
  }

  /// The edges' likelihoods at the solution, on the tape: their gradient is that of U.
  Var lessons(nn::Tape<double>& tape,
              const pgo::PoseVelocityGraph& graph,
              const std::vector<vo::ReplayedMatch>& matches,
              const std::vector<Var>& noises,
              const imu::ImuAnswer& answer) {
    const auto edges = edge_task([&](std::size_t i, const ImuMotion& motion) {
      const auto l = pgo::inertial_likelihood(graph, i, motion);
      return imu::CovarianceSlope{l.nll, l.gradient.covariance};
    });
    Var total = scale(tape, edge_noise_cost(tape, answer, edges), kFrames - 1.0);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const RelativeMotion& measured = graph.visual_edges()[i].motion;
      vo::MotionRecipe recipe;
      recipe.camera = camera_;
      recipe.pose = pose_options_;
      recipe.start = recorded_[i].pose.T_body0_body1;
      const auto at = [&graph, i](const RelativeMotion& motion) {
        const auto l = pgo::visual_likelihood(graph, i, motion);
        return vo::MotionSlope{l.nll, l.gradient.motion, l.gradient.covariance};
      };
      const auto replayed = vo::motion_cost<double>(
          tape, matches[i], recorded_[i].correspondences, recipe, {},
          [&](const RelativeMotion& motion) {
            RelativeMotion same = motion;
            same.covariance = measured.covariance;  // how it depends on the answers: not followed
            return at(same);
          });
      EXPECT_TRUE(replayed.usable);
      RelativeMotion base = measured;
      base.covariance = covariances_[i];
      total = add(tape, total,
                  add(tape, replayed.cost, vo::noise_cost<double>(tape, base, noises[i], at)));
    }
    return total;
  }

  static double half_log_det(const Eigen::MatrixXd& covariance) {
    return -pgo::sqrt_information(covariance)->diagonal().array().log().sum();
  }

  StereoCamera camera_ = [] {
    StereoCamera camera = small_camera();
    camera.width /= 2;
    camera.height /= 2;
    camera.fx = camera.fy = 0.5 * camera.fx;
    camera.cx *= 0.5;
    camera.cy *= 0.5;
    return camera;
  }();
  vo::PoseLayerOptions pose_options_ = [] {
    vo::PoseLayerOptions options;
    options.kernel = "none";
    options.adapt_noise_scale = false;
    options.tolerance = 1e-12;
    options.max_iterations = 100;
    return options;
  }();
  std::shared_ptr<vo::MatchNetwork<float>> shipped_;
  std::unique_ptr<vo::MatchNetwork<double>> match_;
  std::unique_ptr<vo::MotionNoise<double>> noise_;
  std::unique_ptr<imu::ImuNetwork<double>> imu_;
  nn::ParameterList<double> parameters_;
  std::vector<StereoFrame> stereo_;
  std::vector<Recorded> recorded_;
  std::vector<Eigen::Matrix<double, 6, 6>> covariances_;
  std::vector<vo::MotionNoiseFeatures> features_;
  std::vector<ImuSample> samples_;
  ImuNoise noise_model_;
  std::vector<std::int64_t> frame_times_;
  imu::ImuFrameTensors<double> frames_;
  SolveReport report_;
};

/// The derivative of U by number i of a parameter, by central differences.
double numeric(World& world, nn::Parameter<double>& parameter, nn::Index i) {
  const double value = parameter.value[i];
  const double h = 2e-6 * std::max(0.1, std::abs(value));  // wider ones meet kinks of ReLU
  parameter.value[i] = value + h;
  const double above = world.upper_cost();
  parameter.value[i] = value - h;
  const double below = world.upper_cost();
  parameter.value[i] = value;
  return (above - below) / (2.0 * h);
}

TEST(EndToEndGradient, OneStepMatchesCentralDifferencesThroughNetworksLayersAndGraph) {
  World world;
  nn::Gradients<double> gradients = nn::zero_gradients(world.parameters());
  world.upper_cost(&gradients);
  ASSERT_TRUE(world.report().converged) << world.report().reason;
  Random random(11);
  int checked = 0;
  double worst = 0.0;
  for (int draw = 0; checked < 21; ++draw) {
    ASSERT_LT(draw, 3000);
    // A third of the draws from each network.
    const char* const prefix[] = {"match/", "noise/", "imu/"};
    const auto place = static_cast<std::size_t>(
        random.integer(0, static_cast<std::int64_t>(world.parameters().count()) - 1));
    nn::Parameter<double>& parameter = world.parameters()[place];
    if (!parameter.trainable || parameter.name.rfind(prefix[checked % 3], 0) != 0) continue;
    const nn::Index i = random.integer(0, parameter.value.size() - 1);
    const double analytic = gradients[place][i];
    if (std::abs(analytic) < 1e-3) continue;  // below what differences of U resolve
    const double difference = numeric(world, parameter, i);
    const double error = std::abs(analytic - difference) / std::abs(difference);
    worst = std::max(worst, error);
    std::printf("%-40s %12.6g %12.6g %8.1e\n", parameter.name.c_str(), analytic, difference, error);
    EXPECT_LT(error, 1e-4) << parameter.name << " " << i;
    ++checked;
  }
  std::printf("worst relative error of %d derivatives: %.1e\n", checked, worst);
}

}  // namespace
}  // namespace imslam::adaptation
