#include "slam/system/batch_estimator.hpp"

#include <algorithm>

#include "pgo/pose_velocity_graph.hpp"
#include "slam/base/log.hpp"
#include "slam/base/time.hpp"
#include "slam/system/inertial_motions.hpp"

namespace imslam::system {
namespace {

/// Where neither vision nor the IMU measured, the last motion is assumed to go on, this unsurely.
constexpr double kExtrapolationSigma_m_s = 1.0;
constexpr double kExtrapolationSigma_rad_s = 0.5;

RelativeMotion extrapolated_motion(const Trajectory& chain, std::size_t to) {
  RelativeMotion motion;
  motion.time0_ns = chain.times_ns[to - 1];
  motion.time1_ns = chain.times_ns[to];
  motion.T_body0_body1 = chain.poses[to - 1].inverse() * chain.poses[to];
  const double dt_s = to_seconds(motion.time1_ns - motion.time0_ns);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Eigen::Vector3d::Constant(kExtrapolationSigma_m_s * dt_s),
      Eigen::Vector3d::Constant(kExtrapolationSigma_rad_s * dt_s);
  motion.covariance = sigma.cwiseAbs2().asDiagonal();
  motion.valid = true;
  return motion;
}

void add_motion(const Measurements& measurements,
                const RelativeMotion& motion,
                pgo::PoseVelocityGraph& graph) {
  const auto from = measurements.frame_at(motion.time0_ns);
  const auto to = measurements.frame_at(motion.time1_ns);
  if (!from || !to || *from >= *to) return;
  graph.add_visual_edge(static_cast<int>(*from), static_cast<int>(*to), motion);
}

void add_vision(const Measurements& measurements,
                const Estimate& disparity_offset,
                const SystemOptions& options,
                pgo::PoseVelocityGraph& graph) {
  for (const RelativeMotion& motion : measurements.odometry)
    add_motion(measurements, motion, graph);
  for (const RelativeMotion& motion : measurements.skips) add_motion(measurements, motion, graph);
  const double sigma = disparity_offset.sigma.value_or(options.disparity_offset_prior_px);
  graph.add_disparity_offset_prior(disparity_offset.value, sigma);
}

pgo::PoseVelocityGraph visual_graph(const Measurements& measurements,
                                    const OdometryChain& chain,
                                    const Estimate& disparity_offset,
                                    const SlamOptions& options) {
  pgo::PoseVelocityGraph graph(options.pgo);
  for (std::size_t i = 0; i < chain.trajectory.size(); ++i) {
    pgo::State state;
    state.time_ns = chain.trajectory.times_ns[i];
    state.nav.T_world_body = chain.trajectory.poses[i];
    graph.add_state(state);
  }
  graph.anchor_pose(0, lie::SE3d());
  add_vision(measurements, disparity_offset, options.system, graph);
  for (std::size_t i = 1; i < chain.trajectory.size(); ++i) {
    if (!chain.covered[i])
      add_motion(measurements, extrapolated_motion(chain.trajectory, i), graph);
  }
  return graph;
}

void collect(const pgo::PoseVelocityGraph& graph,
             const SystemOptions& options,
             BatchEstimate& out) {
  out.graph = graph.data();
  out.disparity_offset_px.value = graph.globals().disparity_offset;
  if (!options.covariances) return;
  const auto covariances = graph.covariances();
  if (!covariances) return;
  for (const auto& covariance : *covariances) {
    const double variance = covariance.topLeftCorner<3, 3>().trace();
    out.position_sigma_m.push_back(static_cast<float>(std::sqrt(std::max(0.0, variance))));
  }
}

}  // namespace

BatchEstimate estimate_batch(const Measurements& measurements,
                             const Estimate& disparity_offset,
                             const SlamOptions& options) {
  BatchEstimate out;
  const OdometryChain chain = chain_odometry(measurements);
  out.covered = chain.covered;
  auto graph = visual_graph(measurements, chain, disparity_offset, options);
  out.report = graph.solve(options.solver);
  collect(graph, options.system, out);
  return out;
}

}  // namespace imslam::system
