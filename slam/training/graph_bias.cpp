#include "slam/training/graph_bias.hpp"

#include <fmt/format.h>

#include <cmath>

#include "imu_net/gravity_alignment.hpp"
#include "imu_net/preintegration.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/time.hpp"

namespace imslam::training {
namespace {

// Biases that move less than this between two rounds need no new integration.
constexpr double kGyroBiasSettled = 1e-6;   // [rad/s]
constexpr double kAccelBiasSettled = 1e-5;  // [m/s^2]

class GraphBiasEstimator {
 public:
  GraphBiasEstimator(const InertialLog& log, const GraphBiasOptions& options)
      : log_(log), options_(options), noise_(log.noise) {
    noise_.gyro_noise_density *= options.gyro_noise_factor;
    noise_.accel_noise_density *= options.accel_noise_factor;
    choose_states();
  }

  GraphBias estimate() const;

 private:
  void choose_states();
  std::vector<ImuMotion> integrate(const std::vector<pgo::State>& states) const;
  pgo::PoseVelocityGraph graph(const std::vector<pgo::State>& states) const;
  RelativeMotion visual_motion(std::size_t from) const;
  static bool settled(const std::vector<pgo::State>& before, const std::vector<pgo::State>& after);

  const InertialLog& log_;
  const GraphBiasOptions& options_;
  ImuNoise noise_;
  std::vector<bool> jump_;         ///< per state: the truth jumps between the one before and it
  std::vector<pgo::State> start_;  ///< true states, in a world with gravity along -z; no bias
};

void GraphBiasEstimator::choose_states() {
  // The graph's gauge is position and heading about z.
  const lie::SO3d R_level_world = imu::upright_rotation(-log_.gravity_world);
  const std::int64_t step_ns = to_nanoseconds(options_.interval_s);
  auto jump = log_.truth_jumps.begin();
  bool jumped = false;
  for (std::size_t i = 0; i < log_.truth.size(); ++i) {
    const InertialLog::TrueState& truth = log_.truth[i];
    for (; jump != log_.truth_jumps.end() && *jump <= i; ++jump) jumped = true;
    // A tenth early is near enough: stamps jitter.
    if (!start_.empty() && truth.time_ns - start_.back().time_ns < step_ns - step_ns / 10) continue;
    pgo::State state;
    state.time_ns = truth.time_ns;
    state.nav.T_world_body =
        lie::SE3d(R_level_world, Eigen::Vector3d::Zero()) * truth.nav.T_world_body;
    state.nav.v_world = R_level_world * truth.nav.v_world;
    start_.push_back(state);
    jump_.push_back(jumped);
    jumped = false;
  }
}

std::vector<ImuMotion> GraphBiasEstimator::integrate(const std::vector<pgo::State>& states) const {
  std::vector<ImuMotion> motions(states.size() - 1);
  parallel_for(motions.size(), [&](std::size_t i) {
    motions[i] = imu::preintegrate(log_.samples, states[i].time_ns, states[i + 1].time_ns,
                                   states[i].bias, noise_);
  });
  return motions;
}

RelativeMotion GraphBiasEstimator::visual_motion(std::size_t from) const {
  const pgo::State& a = start_[from];
  const pgo::State& b = start_[from + 1];
  RelativeMotion motion;
  motion.time0_ns = a.time_ns;
  motion.time1_ns = b.time_ns;
  motion.T_body0_body1 = a.nav.T_world_body.inverse() * b.nav.T_world_body;
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Eigen::Vector3d::Constant(options_.vision_translation),
      Eigen::Vector3d::Constant(options_.vision_rotation);
  motion.covariance = sigma.cwiseAbs2().asDiagonal();
  motion.valid = true;
  return motion;
}

pgo::PoseVelocityGraph GraphBiasEstimator::graph(const std::vector<pgo::State>& states) const {
  pgo::GraphOptions graph_options;
  graph_options.gravity_magnitude = log_.gravity_world.norm();
  graph_options.gyro_random_walk = noise_.gyro_random_walk;
  graph_options.accel_random_walk = noise_.accel_random_walk;
  pgo::PoseVelocityGraph graph(graph_options);
  for (const pgo::State& state : states) graph.add_state(state);
  const std::vector<ImuMotion> motions = integrate(states);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const int from = static_cast<int>(i);
    if (!jump_[i + 1]) graph.add_visual_edge(from, from + 1, visual_motion(i));
    if (motions[i].valid) graph.add_imu_edge(from, from + 1, motions[i]);
  }
  graph.anchor_position_and_heading(0, start_.front().nav.T_world_body);
  graph.add_bias_prior(0, ImuBias(), noise_.gyro_bias_sigma, noise_.accel_bias_sigma);
  return graph;
}

bool GraphBiasEstimator::settled(const std::vector<pgo::State>& before,
                                 const std::vector<pgo::State>& after) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    const ImuBias& a = before[i].bias;
    const ImuBias& b = after[i].bias;
    if ((a.gyro - b.gyro).norm() > kGyroBiasSettled) return false;
    if ((a.accel - b.accel).norm() > kAccelBiasSettled) return false;
  }
  return true;
}

GraphBias GraphBiasEstimator::estimate() const {
  GraphBias result;
  if (start_.size() < 2) return result;
  std::vector<pgo::State> states = start_;
  for (int round = 0;; ++round) {
    pgo::PoseVelocityGraph g = graph(states);
    result.report = g.solve(options_.solver);
    const bool last = round == options_.relinearisations || settled(states, g.states());
    states = g.states();
    if (!last) continue;
    for (const pgo::State& state : states) result.biases.push_back({state.time_ns, state.bias});
    const auto uncertainty = g.uncertainty();
    if (!uncertainty) return result;
    for (std::size_t i = 0; i < states.size(); ++i) {
      const Eigen::Matrix<double, 6, 1> sigma =
          uncertainty->states[i].diagonal().tail<6>().cwiseMax(0.0).cwiseSqrt();
      result.bias_sigma.push_back({states[i].time_ns, {sigma.head<3>(), sigma.tail<3>()}});
    }
    return result;
  }
}

}  // namespace

GraphBias estimate_graph_bias(const InertialLog& log, const GraphBiasOptions& options) {
  return GraphBiasEstimator(log, options).estimate();
}

InertialMethod graph_bias_method(const GraphBiasOptions& options) {
  return {"graph bias", [options](const InertialLog& log) {
            GraphBias graph = estimate_graph_bias(log, options);
            InertialMethod::Result result;
            result.correction.corrected = {log.samples, std::move(graph.bias_sigma)};
            result.correction.start_bias = std::move(graph.biases);
            result.remark =
                fmt::format("{} states{}", result.correction.start_bias.size(),
                            graph.report.converged ? "" : ", not solved: " + graph.report.reason);
            return result;
          }};
}

}  // namespace imslam::training
