#include "pgo/paper_window.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>

#include "pgo/ceres_solve.hpp"
#include "pgo/paper_factors.hpp"
#include "pgo/prediction.hpp"
#include "pgo/prior_factors.hpp"
#include "pgo/relative_pose_factor.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::pgo {
namespace {

using Eigen::Vector3d;

/// One window as a Ceres problem.
class Window {
 public:
  Window(const State& first, const PaperOptions& options)
      : weights_(options.weights()), gravity_(0.0, 0.0, -options.gravity_magnitude) {
    add_state(first);
    R_predicted_ = first.nav.T_world_body.rotation();
    problem_.SetParameterBlockConstant(poses_[0].data());
    problem_.SetParameterBlockConstant(velocities_[0].data());
  }

  void add_step(const RelativeMotion& visual, const ImuMotion& inertial) {
    State guess = states_.back();
    const double dt = to_seconds(visual.time1_ns - visual.time0_ns);
    if (inertial.valid) guess = predict(guess, inertial, gravity_);
    if (visual.valid) {
      const State seen = predict(states_.back(), visual);
      guess.nav.T_world_body = seen.nav.T_world_body;
      if (!inertial.valid) guess.nav.v_world = seen.nav.v_world;
    }
    if (!visual.valid && !inertial.valid) {
      guess.nav.T_world_body =
          lie::SE3d(guess.nav.T_world_body.rotation(),
                    guess.nav.T_world_body.translation() + guess.nav.v_world * dt);
    }
    guess.time_ns = visual.time1_ns;
    add_state(guess);
    if (visual.valid) add_visual(visual);
    if (inertial.valid) add_inertial(inertial);
    hold_unseen(visual.valid, inertial.valid);
  }

  SolveReport solve(const SolverOptions& options) { return solve_with_ceres(problem_, options); }

  /// All states but the first.
  std::vector<State> solution() const {
    std::vector<State> result;
    for (std::size_t i = 1; i < states_.size(); ++i) {
      State state = states_[i];
      state.nav.T_world_body = pose_from_block(poses_[i].data());
      state.nav.v_world = Eigen::Map<const Vector3d>(velocities_[i].data());
      if (!state.nav.T_world_body.matrix().allFinite() || !state.nav.v_world.allFinite()) {
        state = states_[i];
      }
      result.push_back(state);
    }
    return result;
  }

 private:
  void add_state(const State& state) {
    states_.push_back(state);
    poses_.emplace_back();
    velocities_.emplace_back();
    pose_to_block(state.nav.T_world_body, poses_.back().data());
    Eigen::Map<Vector3d>(velocities_.back().data()) = state.nav.v_world;
    problem_.AddParameterBlock(poses_.back().data(), 7, new PoseManifold);
    problem_.AddParameterBlock(velocities_.back().data(), 3);
  }

  void add_visual(const RelativeMotion& motion) {
    RelativeMotion fixed = motion;
    fixed.J_disparity_offset.setZero();
    fixed.J_focal_error.setZero();
    const Eigen::Matrix<double, 6, 6> W = weights_.visual * Eigen::Matrix<double, 6, 6>::Identity();
    problem_.AddResidualBlock(new RelativePoseFactor(fixed, W), nullptr, pose(-2), pose(-1),
                              &no_offset_, &no_focal_error_, no_rotation_.data());
    problem_.SetParameterBlockConstant(&no_offset_);
    problem_.SetParameterBlockConstant(&no_focal_error_);
    problem_.SetParameterBlockConstant(no_rotation_.data());
  }

  void add_inertial(const ImuMotion& motion) {
    const double dt = motion.dt_s;
    const Vector3d dv_world = R_predicted_ * motion.dv + gravity_ * dt;
    const Vector3d dp_world = R_predicted_ * motion.dp + gravity_ * (0.5 * dt * dt);
    problem_.AddResidualBlock(new VelocityStepFactor(dv_world, weights_.velocity_step), nullptr,
                              velocity(-2), velocity(-1));
    problem_.AddResidualBlock(new RotationStepFactor(motion.dR, weights_.rotation_step), nullptr,
                              pose(-2), pose(-1));
    problem_.AddResidualBlock(
        new TranslationVelocityFactor(dp_world, dt, weights_.translation_velocity), nullptr,
        pose(-2), velocity(-2), pose(-1));
    R_predicted_ = R_predicted_ * motion.dR;
  }

  /// What no residual of this step determines stays tied to its guess.
  void hold_unseen(bool visual, bool inertial) {
    if (!inertial) {
      problem_.AddResidualBlock(new VelocityStepFactor(states_.back().nav.v_world -
                                                           states_[states_.size() - 2].nav.v_world,
                                                       weights_.velocity_step),
                                nullptr, velocity(-2), velocity(-1));
      R_predicted_ = states_.back().nav.T_world_body.rotation();
    }
    if (!visual && !inertial) {
      RelativeMotion guess;
      guess.T_body0_body1 =
          states_[states_.size() - 2].nav.T_world_body.inverse() * states_.back().nav.T_world_body;
      add_visual(guess);
    }
  }

  double* pose(int from_end) {
    return poses_[static_cast<std::size_t>(static_cast<int>(poses_.size()) + from_end)].data();
  }
  double* velocity(int from_end) {
    return velocities_[static_cast<std::size_t>(static_cast<int>(velocities_.size()) + from_end)]
        .data();
  }

  PaperWeights weights_;
  Vector3d gravity_;
  lie::SO3d R_predicted_;
  std::vector<State> states_;  ///< first guesses
  std::deque<std::array<double, 7>> poses_;
  std::deque<std::array<double, 3>> velocities_;
  double no_offset_ = 0.0;
  double no_focal_error_ = 0.0;
  std::array<double, 3> no_rotation_{};
  ceres::Problem problem_;
};

}  // namespace

PaperWeights PaperOptions::weights() const {
  return dataset == "kitti" ? PaperWeights::kitti() : PaperWeights::euroc();
}

void PaperOptions::describe(Config& config) {
  config.field("dataset", dataset, {"euroc", "kitti"}, "whose published weights to use");
  config.field("window_steps", window_steps, "motions per window");
  config.field("gravity", gravity_magnitude, "magnitude of gravity [m/s^2]");
}

void PaperOptions::validate() const {
  if (dataset != "euroc" && dataset != "kitti") {
    throw InputError("pgo.paper.dataset = " + dataset + ": expected euroc or kitti",
                     ExitCode::kUsage);
  }
  if (window_steps < 1 || window_steps > 100000) {
    throw InputError(
        "pgo.paper.window_steps = " + std::to_string(window_steps) + ": expected 1 to 100000",
        ExitCode::kUsage);
  }
  if (!(gravity_magnitude > 0.0 && gravity_magnitude < 100.0)) {
    throw InputError("pgo.paper.gravity = " + std::to_string(gravity_magnitude) +
                         ": expected more than 0 and less than 100 m/s^2",
                     ExitCode::kUsage);
  }
}

PaperResult solve_paper_windows(const State& first,
                                const std::vector<RelativeMotion>& visual,
                                const std::vector<ImuMotion>& inertial,
                                const PaperOptions& options,
                                const SolverOptions& solver) {
  options.validate();
  solver.validate();
  expects(visual.size() == inertial.size(), "paper windows: one motion of each kind per interval");
  PaperResult result;
  result.states = {first};
  const auto steps = static_cast<std::size_t>(options.window_steps);
  for (std::size_t begin = 0; begin < visual.size(); begin += steps) {
    Window window(result.states.back(), options);
    const std::size_t end = std::min(begin + steps, visual.size());
    for (std::size_t i = begin; i < end; ++i) window.add_step(visual[i], inertial[i]);
    result.reports.push_back(window.solve(solver));
    const std::vector<State> solved = window.solution();
    result.states.insert(result.states.end(), solved.begin(), solved.end());
  }
  return result;
}

}  // namespace imslam::pgo
