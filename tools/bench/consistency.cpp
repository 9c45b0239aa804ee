#include "tools/bench/consistency.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "imu_net/preintegration.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "pgo/prediction.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/random.hpp"
#include "slam/base/time.hpp"

namespace imslam::bench {
namespace {

using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const Vector3d kGravity(0.0, 0.0, -9.81);

/// Attitude and acceleration of a vehicle on a wavy loop.
lie::SO3d attitude(double t) {
  return lie::SO3d::exp(Vector3d(0.0, 0.0, 0.6 * t)) *
         lie::SO3d::exp(Vector3d(0.25 * std::sin(1.1 * t), 0.2 * std::sin(1.7 * t), 0.0));
}
Vector3d acceleration(double t) {
  return {1.5 * std::sin(0.8 * t), 1.2 * std::cos(1.3 * t), 0.8 * std::sin(1.9 * t)};
}

ImuSample exact_reading(double t) {
  constexpr double kStep = 1e-4;
  ImuSample sample;
  sample.time_ns = to_nanoseconds(t);
  sample.angular_velocity =
      (attitude(t - kStep).inverse() * attitude(t + kStep)).log() / (2.0 * kStep);
  sample.linear_acceleration = attitude(t).inverse() * (acceleration(t) - kGravity);
  return sample;
}

/// What all runs share: exact readings and the states they lead to.
struct World {
  std::vector<ImuSample> samples;
  std::vector<pgo::State> truth;
};

World make_world(const ConsistencyOptions& options, const ImuNoise& noise) {
  World world;
  const double duration_s = (options.frames - 1) / options.frame_rate_hz;
  const int margin = 2;
  const int count = static_cast<int>(std::ceil(duration_s * options.imu_rate_hz)) + margin;
  for (int i = -margin; i <= count; ++i) {
    world.samples.push_back(exact_reading(1.0 + i / options.imu_rate_hz));
  }
  pgo::State state;
  state.time_ns = to_nanoseconds(1.0);
  state.nav.T_world_body = lie::SE3d(attitude(1.0), Vector3d::Zero());
  state.nav.v_world << 0.5, 1.0, 0.2;
  world.truth.push_back(state);
  for (int i = 1; i < options.frames; ++i) {
    const std::int64_t time1_ns = to_nanoseconds(1.0 + i / options.frame_rate_hz);
    const ImuMotion motion = imu::preintegrate(world.samples, state.time_ns, time1_ns, {}, noise);
    state = pgo::predict(state, motion, kGravity);
    world.truth.push_back(state);
  }
  return world;
}

struct Run {
  std::vector<double> pose_nees;
  std::vector<double> velocity_nees;
  double largest_position_error_m = 0.0;
};

std::vector<ImuSample> noisy_samples(const World& world,
                                     const ConsistencyOptions& options,
                                     const ImuNoise& noise,
                                     Random& random) {
  const double dt = 1.0 / options.imu_rate_hz;
  const double gyro_sigma = options.noise * noise.gyro_noise_density / std::sqrt(dt);
  const double accel_sigma = options.noise * noise.accel_noise_density / std::sqrt(dt);
  Vector3d gyro_bias = options.noise * options.gyro_bias_sigma * random.normal3();
  Vector3d accel_bias = options.noise * options.accel_bias_sigma * random.normal3();
  std::vector<ImuSample> samples = world.samples;
  for (ImuSample& sample : samples) {
    sample.angular_velocity += gyro_bias + gyro_sigma * random.normal3();
    sample.linear_acceleration += accel_bias + accel_sigma * random.normal3();
    gyro_bias += options.noise * noise.gyro_random_walk * std::sqrt(dt) * random.normal3();
    accel_bias += options.noise * noise.accel_random_walk * std::sqrt(dt) * random.normal3();
  }
  return samples;
}

RelativeMotion noisy_visual(const pgo::State& a,
                            const pgo::State& b,
                            const ConsistencyOptions& options,
                            Random& random) {
  Vector6 sigma;
  sigma << Vector3d::Constant(options.visual_sigma_m), Vector3d::Constant(options.visual_sigma_rad);
  Vector6 error;
  error << random.normal3(), random.normal3();
  RelativeMotion motion;
  motion.time0_ns = a.time_ns;
  motion.time1_ns = b.time_ns;
  // T_true = T Exp(e)
  motion.T_body0_body1 = a.nav.T_world_body.inverse() * b.nav.T_world_body *
                         lie::SE3d::exp(-options.noise * sigma.cwiseProduct(error));
  motion.covariance = sigma.cwiseAbs2().asDiagonal();
  motion.valid = true;
  return motion;
}

pgo::PoseVelocityGraph build_graph(const World& world,
                                   const ConsistencyOptions& options,
                                   const ImuNoise& noise,
                                   const ImuBias& bias,
                                   const std::vector<RelativeMotion>& visual,
                                   const std::vector<ImuSample>& samples) {
  pgo::GraphOptions graph_options;
  graph_options.kernel = "none";
  graph_options.gyro_random_walk = noise.gyro_random_walk;
  graph_options.accel_random_walk = noise.accel_random_walk;
  pgo::PoseVelocityGraph graph(graph_options);
  pgo::State first = world.truth[0];
  first.bias = bias;
  const std::vector<pgo::State> guesses = pgo::chain_states(first, visual);
  for (const pgo::State& guess : guesses) graph.add_state(guess);
  for (std::size_t i = 0; i < visual.size(); ++i) {
    const auto from = static_cast<int>(i);
    graph.add_visual_edge(from, from + 1, visual[i]);
    graph.add_imu_edge(
        from, from + 1,
        imu::preintegrate(samples, visual[i].time0_ns, visual[i].time1_ns, bias, noise));
  }
  graph.anchor_position_and_heading(0, world.truth[0].nav.T_world_body);
  graph.add_bias_prior(0, {}, options.gyro_bias_sigma, options.accel_bias_sigma);
  return graph;
}

Run run_once(const World& world,
             const ConsistencyOptions& options,
             const ImuNoise& noise,
             Random random) {
  const std::vector<ImuSample> samples = noisy_samples(world, options, noise, random);
  std::vector<RelativeMotion> visual;
  for (std::size_t i = 0; i + 1 < world.truth.size(); ++i) {
    visual.push_back(noisy_visual(world.truth[i], world.truth[i + 1], options, random));
  }
  pgo::SolverOptions solver;
  solver.threads = 1;
  // Twice: the second time integrated with the bias found, as the system does.
  pgo::PoseVelocityGraph graph = build_graph(world, options, noise, {}, visual, samples);
  graph.solve(solver);
  graph = build_graph(world, options, noise, graph.states()[0].bias, visual, samples);
  graph.solve(solver);

  Run run;
  const auto covariances = graph.covariances();
  for (std::size_t i = 0; i < world.truth.size(); ++i) {
    const lie::NavState& estimate = graph.states()[i].nav;
    const lie::NavState::Tangent error = world.truth[i].nav.minus(estimate);
    run.largest_position_error_m = std::max(
        run.largest_position_error_m,
        (world.truth[i].nav.T_world_body.translation() - estimate.T_world_body.translation())
            .norm());
    if (i == 0 || !covariances) continue;
    const auto& P = (*covariances)[i];
    const Vector6 pose = error.head<6>();
    const Vector3d velocity = error.tail<3>();
    run.pose_nees.push_back(pose.dot(P.topLeftCorner<6, 6>().ldlt().solve(pose)));
    run.velocity_nees.push_back(velocity.dot(P.block<3, 3>(6, 6).ldlt().solve(velocity)));
  }
  return run;
}

double share_inside(const std::vector<double>& nees, const Band& band) {
  const auto inside = std::count_if(nees.begin(), nees.end(),
                                    [&](double x) { return x >= band.low && x <= band.high; });
  return nees.empty() ? 0.0 : static_cast<double>(inside) / static_cast<double>(nees.size());
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

RunAverage average_over_runs(const std::vector<Run>& runs, std::vector<double> Run::*nees) {
  std::vector<double> averages;
  for (const Run& run : runs) averages.push_back(mean_of(run.*nees));
  RunAverage result;
  result.mean = mean_of(averages);
  double squares = 0.0;
  for (double average : averages) squares += std::pow(average - result.mean, 2);
  const double count = static_cast<double>(averages.size());
  result.standard_error = std::sqrt(squares / std::max(1.0, count - 1.0) / count);
  return result;
}

}  // namespace

Band average_nees_band(int dof, int runs) {
  const double k = static_cast<double>(dof) * runs;
  const auto quantile = [k](double z) {
    return k * std::pow(1.0 - 2.0 / (9.0 * k) + z * std::sqrt(2.0 / (9.0 * k)), 3.0);
  };
  constexpr double kNormal975 = 1.959963984540054;
  return {quantile(-kNormal975) / runs, quantile(kNormal975) / runs};
}

ConsistencyResult study_consistency(const ConsistencyOptions& options) {
  ImuNoise noise;
  noise.rate_hz = options.imu_rate_hz;
  const World world = make_world(options, noise);
  const Random random(options.seed);
  std::vector<Run> runs(static_cast<std::size_t>(options.runs));
  parallel_for(runs.size(),
               [&](std::size_t i) { runs[i] = run_once(world, options, noise, random.fork(i)); });

  ConsistencyResult result;
  const std::size_t frames = world.truth.size() - 1;
  result.pose_nees.assign(frames, 0.0);
  result.velocity_nees.assign(frames, 0.0);
  for (const Run& run : runs) {
    result.largest_position_error_m =
        std::max(result.largest_position_error_m, run.largest_position_error_m);
    for (std::size_t i = 0; i < run.pose_nees.size(); ++i) {
      result.pose_nees[i] += run.pose_nees[i] / options.runs;
      result.velocity_nees[i] += run.velocity_nees[i] / options.runs;
    }
  }
  result.pose = average_over_runs(runs, &Run::pose_nees);
  result.velocity = average_over_runs(runs, &Run::velocity_nees);
  result.pose_inside = share_inside(result.pose_nees, average_nees_band(6, options.runs));
  result.velocity_inside = share_inside(result.velocity_nees, average_nees_band(3, options.runs));
  return result;
}

}  // namespace imslam::bench
