#include "slam/system/batch_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pgo/paper_window.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "slam/base/time.hpp"
#include "slam/system/conflicts.hpp"
#include "slam/system/inertial_motions.hpp"
#include "slam/system/inertial_start.hpp"
#include "slam/system/resting_frames.hpp"

namespace imslam::system {
namespace {

// Biases that move less than this between two rounds need no new integration.
constexpr double kGyroBiasSettled = 1e-6;   // [rad/s]
constexpr double kAccelBiasSettled = 1e-5;  // [m/s^2]
constexpr double kTimeOffsetSettled_s = 1e-6;

constexpr double kLongestBridge_s = 2.0;

/// Builds and solves the graph; one object per run.
class BatchEstimator {
 public:
  BatchEstimator(const Measurements& measurements,
                 const Estimate& disparity_offset,
                 const SlamOptions& options)
      : measurements_(measurements),
        disparity_offset_(disparity_offset),
        options_(options),
        chain_(chain_odometry(measurements)) {
    out_.covered = chain_.covered;
  }

  BatchEstimate estimate() {
    if (measurements_.readings().empty() || !estimate_with_imu()) estimate_with_vision();
    return std::move(out_);
  }

 private:
  // ---- vision only

  void estimate_with_vision() {
    std::vector<pgo::State> start(chain_.trajectory.size());
    for (std::size_t i = 0; i < start.size(); ++i) {
      start[i].time_ns = chain_.trajectory.times_ns[i];
      start[i].nav.T_world_body = chain_.trajectory.poses[i];
    }
    pgo::GraphOptions graph_options = options_.pgo;
    graph_options.estimate_time_offset = false;
    graph_options.estimate_focal_error = false;  // vision alone cannot tell it from the turn
    graph_options.estimate_camera_rotation = false;
    graph_options.estimate_gyro_shape = false;
    pgo::PoseVelocityGraph graph = vision_graph(start, graph_options);
    graph.anchor_pose(0, start.front().nav.T_world_body);
    for (std::size_t i = 1; i < start.size(); ++i) {
      if (!chain_.covered[i]) add_motion(bridge(chain_.trajectory, i), graph);
    }
    out_.report = graph.solve(options_.solver);
    collect(graph);
  }

  pgo::PoseVelocityGraph vision_graph(const std::vector<pgo::State>& start,
                                      const pgo::GraphOptions& graph_options) const {
    pgo::PoseVelocityGraph graph(graph_options);
    graph.set_camera(measurements_.T_body_left);
    for (const pgo::State& state : start) graph.add_state(state);
    for (const RelativeMotion& motion : measurements_.odometry) add_motion(motion, graph);
    for (const RelativeMotion& motion : measurements_.skips) add_motion(motion, graph);
    if (disparity_offset_.sigma) {
      graph.add_disparity_offset_prior(disparity_offset_.value, *disparity_offset_.sigma);
    }
    return graph;
  }

  void add_motion(const RelativeMotion& motion, pgo::PoseVelocityGraph& graph) const {
    const auto from = measurements_.frame_at(motion.time0_ns);
    const auto to = measurements_.frame_at(motion.time1_ns);
    if (!from || !to || *from >= *to) return;
    graph.add_visual_edge(static_cast<int>(*from), static_cast<int>(*to), motion);
  }

  // ---- vision and IMU

  /// False, with a warning, if the IMU cannot be brought into play.
  bool estimate_with_imu() {
    InertialStart start = start_inertial(measurements_, chain_, options_);
    if (start.states.empty()) {
      out_.warnings.push_back("IMU not used: " + start.reason);
      return false;
    }
    out_.inertial = true;
    mark_covered(start.inertial);
    if (options_.system.preset == "paper") {
      estimate_as_published(start);
    } else {
      estimate_tightly(start);
    }
    out_.conflict = rotation_conflicts(measurements_, start.inertial);
    return true;
  }

  /// Solve, integrate anew at the biases found, and again until they stand still.
  /// Leaves the last integration in `start.inertial`.
  void estimate_tightly(InertialStart& start) {
    std::vector<pgo::State> states = std::move(start.states);
    pgo::Globals globals;
    globals.time_offset_s = start.time_offset_s;
    globals.disparity_offset = disparity_offset_.value;
    for (int round = 0;; ++round) {
      pgo::PoseVelocityGraph graph = inertial_graph(states, globals, start.inertial);
      out_.report = graph.solve(options_.solver);
      const bool last = round == options_.system.relinearisations;
      if (last || settled(states, globals, graph)) {
        out_.time_offset_s = Estimate{graph.globals().time_offset_s, start.time_offset_sigma_s};
        collect(graph);
        return;
      }
      states = graph.states();
      globals = graph.globals();
      start.inertial = integrate_intervals(
          measurements_, [&](std::size_t i) { return states[i].bias; }, globals.time_offset_s,
          options_.preintegration);
    }
  }

  /// The published graph: windows of eight steps, constant weights.
  void estimate_as_published(const InertialStart& start) {
    pgo::PaperOptions paper;
    paper.dataset = options_.system.paper_weights;
    paper.gravity_magnitude = options_.pgo.gravity_magnitude;
    const auto result = pgo::solve_paper_windows(start.states.front(), start.visual, start.inertial,
                                                 paper, options_.solver);
    out_.graph.states = result.states;
    out_.report.converged = true;
    out_.report.reason = "published windows";
    for (const SolveReport& report : result.reports) {
      out_.report.converged = out_.report.converged && report.converged;
      out_.report.iterations += report.iterations;
      out_.report.cost += report.cost;
    }
    out_.time_offset_s = Estimate{start.time_offset_s, start.time_offset_sigma_s};
  }

  pgo::PoseVelocityGraph inertial_graph(const std::vector<pgo::State>& start,
                                        const pgo::Globals& globals,
                                        const std::vector<ImuMotion>& motions) const {
    const SystemOptions& system = options_.system;
    pgo::GraphOptions graph_options = options_.pgo;
    graph_options.gyro_random_walk = measurements_.imu_noise.gyro_random_walk;
    graph_options.accel_random_walk = measurements_.imu_noise.accel_random_walk;
    graph_options.estimate_camera_rotation =
        graph_options.estimate_camera_rotation &&
        measurements_.imu_noise.gyro_bias_sigma <= system.trusted_gyro_bias;
    graph_options.estimate_gyro_shape =
        graph_options.estimate_gyro_shape && measurements_.gyro_shape_sigma > 0.0;
    pgo::PoseVelocityGraph graph = vision_graph(start, graph_options);
    graph.set_globals(globals);
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const auto from = static_cast<int>(i);
      const bool used = motions[i].valid && graph.add_imu_edge(from, from + 1, motions[i]);
      if (!used && !chain_.covered[i + 1]) {
        add_motion(bridge(chain_.trajectory, i + 1), graph);
      }
    }
    graph.anchor_position_and_heading(0, start.front().nav.T_world_body);
    const ImuNoise& sensor = measurements_.imu_noise;
    graph.add_bias_prior(
        0, ImuBias(),
        system.gyro_bias_prior > 0.0 ? system.gyro_bias_prior : sensor.gyro_bias_sigma,
        system.accel_bias_prior > 0.0 ? system.accel_bias_prior : sensor.accel_bias_sigma);
    add_bias_beliefs(graph);
    graph.add_focal_error_prior(0.0, system.focal_error_prior);
    graph.add_time_offset_prior(system.time_offset_s, system.time_offset_prior_s);
    graph.add_camera_rotation_prior(Eigen::Vector3d::Zero(), system.camera_rotation_prior);
    if (graph_options.estimate_gyro_shape) {
      graph.add_gyro_shape_prior(Eigen::Matrix3d::Zero(), measurements_.gyro_shape_sigma);
    }
    if (system.zero_velocity && !motions.empty()) {
      const double sigma = system.zero_velocity_sigma;
      for (const std::size_t frame : resting_frames(measurements_, sigma, options_.still)) {
        graph.add_zero_velocity(static_cast<int>(frame), sigma);
      }
    }
    return graph;
  }

  /// Each axis once, where the correction was surest: its beliefs of other times are no news.
  void add_bias_beliefs(pgo::PoseVelocityGraph& graph) const {
    constexpr double kAnything = 1e3;  // [rad/s], [m/s^2]
    const auto& times_ns = measurements_.times_ns;
    for (const BiasBelief& belief : measurements_.bias_beliefs) {
      const auto frame = std::lower_bound(times_ns.begin(), times_ns.end() - 1, belief.time_ns);
      ImuBias bias;
      ImuBias sigma{Eigen::Vector3d::Constant(kAnything), Eigen::Vector3d::Constant(kAnything)};
      Eigen::Vector3d& values = belief.axis < 3 ? bias.gyro : bias.accel;
      Eigen::Vector3d& sigmas = belief.axis < 3 ? sigma.gyro : sigma.accel;
      values[belief.axis % 3] = belief.bias;
      sigmas[belief.axis % 3] = belief.sigma;
      graph.add_bias_prior(static_cast<int>(frame - times_ns.begin()), bias, sigma);
    }
  }

  /// Whether another integration of the IMU would change nothing that matters.
  static bool settled(const std::vector<pgo::State>& before,
                      const pgo::Globals& globals_before,
                      const pgo::PoseVelocityGraph& graph) {
    for (std::size_t i = 0; i < before.size(); ++i) {
      const ImuBias& now = graph.states()[i].bias;
      if ((now.gyro - before[i].bias.gyro).norm() > kGyroBiasSettled) return false;
      if ((now.accel - before[i].bias.accel).norm() > kAccelBiasSettled) return false;
    }
    return std::abs(graph.globals().time_offset_s - globals_before.time_offset_s) <
           kTimeOffsetSettled_s;
  }

  void mark_covered(const std::vector<ImuMotion>& motions) {
    out_.imu_gap.assign(chain_.covered.size(), false);
    std::int64_t seen_ns = measurements_.times_ns.front();
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const std::int64_t time_ns = measurements_.times_ns[i + 1];
      const bool bridged = motions[i].valid && !motions[i].degraded;
      out_.imu_gap[i + 1] = !bridged;
      if (chain_.covered[i + 1]) seen_ns = time_ns;
      out_.covered[i + 1] =
          chain_.covered[i + 1] || (bridged && to_seconds(time_ns - seen_ns) <= kLongestBridge_s);
    }
  }

  void collect(const pgo::PoseVelocityGraph& graph) {
    out_.graph = graph.data();
    out_.graph_options = graph.options();
    const pgo::Globals& globals = graph.globals();
    out_.disparity_offset_px = {globals.disparity_offset, disparity_offset_.sigma};
    if (graph.options().estimate_focal_error) {
      out_.focal_error = Estimate{globals.focal_error, std::nullopt};
    }
    if (graph.options().estimate_camera_rotation) {
      out_.camera_rotation = VectorEstimate{globals.camera_rotation, std::nullopt};
    }
    if (graph.options().estimate_gyro_shape) {
      out_.gyro_shape = ShapeEstimate{globals.gyro_shape, std::nullopt};
    }
    if (!options_.system.covariances) return;
    const auto uncertainty = graph.uncertainty();
    if (!uncertainty) return;
    for (const auto& covariance : uncertainty->states) {
      const double variance = covariance.topLeftCorner<3, 3>().trace();
      out_.position_sigma_m.push_back(static_cast<float>(std::sqrt(std::max(0.0, variance))));
    }
    collect_sigmas(uncertainty->globals);
  }

  /// Where the graph estimates a number, its own standard deviation takes the place of that of the
  /// first guess.
  void collect_sigmas(const pgo::GlobalSigmas& sigmas) {
    if (sigmas.disparity_offset) out_.disparity_offset_px.sigma = sigmas.disparity_offset;
    if (out_.focal_error) out_.focal_error->sigma = sigmas.focal_error;
    if (out_.camera_rotation) out_.camera_rotation->sigma = sigmas.camera_rotation;
    if (out_.gyro_shape) out_.gyro_shape->sigma = sigmas.gyro_shape;
    if (out_.time_offset_s && sigmas.time_offset_s) {
      out_.time_offset_s->sigma = sigmas.time_offset_s;
    }
  }

  const Measurements& measurements_;
  const Estimate disparity_offset_;
  const SlamOptions& options_;
  OdometryChain chain_;
  BatchEstimate out_;
};

}  // namespace

BatchEstimate estimate_batch(const Measurements& measurements,
                             const Estimate& disparity_offset,
                             const SlamOptions& options) {
  BatchEstimate estimate = BatchEstimator(measurements, disparity_offset, options).estimate();
  const auto kept = without_conflicts(measurements, estimate.conflict);
  if (!kept) return estimate;
  BatchEstimate gated = BatchEstimator(*kept, disparity_offset, options).estimate();
  if (!gated.inertial) return estimate;  // what is left does not start the IMU
  gated.conflict = std::move(estimate.conflict);
  return gated;
}

}  // namespace imslam::system
