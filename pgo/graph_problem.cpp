#include "pgo/graph_problem.hpp"

#include <algorithm>
#include <cmath>

#include "pgo/robust_loss.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::pgo {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

ceres::Problem::Options problem_options() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;  // our own code names the blocks
  return options;
}

template <std::size_t kSize>
bool all_finite(const std::vector<std::array<double, kSize>>& blocks) {
  return std::all_of(blocks.begin(), blocks.end(), [](const auto& block) {
    return std::all_of(block.begin(), block.end(), [](double x) { return std::isfinite(x); });
  });
}

}  // namespace

bool has_biases(const GraphData& data) {
  const auto is_bias = [](const BlockId& id) { return id.kind == BlockId::Kind::kBias; };
  return !data.inertial_edges.empty() || !data.bias_priors.empty() ||
         std::any_of(data.marginal.blocks.begin(), data.marginal.blocks.end(), is_bias);
}

GraphProblem::GraphProblem(const GraphData& data, const GraphOptions& options, BiasWalks walks)
    : options_(options), problem_(std::make_unique<ceres::Problem>(problem_options())) {
  copy_blocks(data);
  loss_ = make_loss(options);
  add_visual_edges(data);
  add_inertial_edges(data);
  add_bias_walks(data, walks);
  add_state_priors(data);
  add_global_priors(data);
  add_marginal_prior(data);
  set_manifolds();
  hold_globals();
}

void GraphProblem::copy_blocks(const GraphData& data) {
  const std::size_t count = data.states.size();
  poses_.resize(count);
  velocities_.resize(count);
  biases_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const State& state = data.states[i];
    pose_to_block(state.nav.T_world_body, poses_[i].data());
    Eigen::Map<Eigen::Vector3d>(velocities_[i].data()) = state.nav.v_world;
    Eigen::Map<Vector6>(biases_[i].data()) << state.bias.gyro, state.bias.accel;
  }
  Eigen::Map<Eigen::Vector3d>(gravity_direction_.data()) = data.globals.gravity_direction;
  disparity_offset_ = data.globals.disparity_offset;
  focal_error_ = data.globals.focal_error;
  time_offset_s_ = data.globals.time_offset_s;
  Eigen::Map<Eigen::Vector3d>(camera_rotation_.data()) = data.globals.camera_rotation;
  Eigen::Map<RowMajor3>(gyro_shape_.data()) = data.globals.gyro_shape;
}

void GraphProblem::add_visual_edges(const GraphData& data) {
  visual_ids_.reserve(data.visual_edges.size());
  for (const VisualEdge& edge : data.visual_edges) {
    visual_factors_.emplace_back(edge.motion, edge.sqrt_information, data.T_body_left);
    visual_ids_.push_back(problem_->AddResidualBlock(
        &visual_factors_.back(), loss_.get(), poses_[static_cast<std::size_t>(edge.from)].data(),
        poses_[static_cast<std::size_t>(edge.to)].data(), &disparity_offset_, &focal_error_,
        camera_rotation_.data()));
  }
}

void GraphProblem::add_inertial_edges(const GraphData& data) {
  inertial_ids_.reserve(data.inertial_edges.size());
  for (const InertialEdge& edge : data.inertial_edges) {
    const auto from = static_cast<std::size_t>(edge.from);
    const auto to = static_cast<std::size_t>(edge.to);
    inertial_factors_.emplace_back(edge.motion, edge.sqrt_information, options_.gravity_magnitude);
    inertial_ids_.push_back(problem_->AddResidualBlock(
        &inertial_factors_.back(), nullptr, poses_[from].data(), velocities_[from].data(),
        poses_[to].data(), velocities_[to].data(), biases_[from].data(), gravity_direction_.data(),
        &time_offset_s_, gyro_shape_.data()));
  }
}

/// The bias drifts from state to state, also through intervals without IMU data.
void GraphProblem::add_bias_walks(const GraphData& data, BiasWalks walks) {
  if (walks == BiasWalks::kNone || (walks == BiasWalks::kAuto && !has_biases(data))) return;
  const std::size_t end = walks == BiasWalks::kFirst ? 2 : data.states.size();
  for (std::size_t i = 1; i < end; ++i) {
    const double dt_s = to_seconds(data.states[i].time_ns - data.states[i - 1].time_ns);
    bias_walks_.emplace_back(options_.gyro_random_walk, options_.accel_random_walk, dt_s);
    problem_->AddResidualBlock(&bias_walks_.back(), nullptr, biases_[i - 1].data(),
                               biases_[i].data());
  }
}

void GraphProblem::add_state_priors(const GraphData& data) {
  const auto add = [this](std::unique_ptr<ceres::CostFunction> factor, double* block) {
    priors_.push_back(std::move(factor));
    problem_->AddResidualBlock(priors_.back().get(), nullptr, block);
  };
  for (const PosePrior& prior : data.pose_priors) {
    add(std::make_unique<PosePriorFactor>(prior.T_world_body, prior.sqrt_information),
        poses_[static_cast<std::size_t>(prior.state)].data());
  }
  for (const Anchor& anchor : data.anchors) {
    add(std::make_unique<AnchorFactor>(anchor.T_world_body, anchor.sigma_position_m,
                                       anchor.sigma_yaw_rad),
        poses_[static_cast<std::size_t>(anchor.state)].data());
  }
  for (const VelocityPrior& prior : data.velocity_priors) {
    add(std::make_unique<VectorPriorFactor<3>>(prior.v_world,
                                               Eigen::Vector3d::Constant(prior.sigma)),
        velocities_[static_cast<std::size_t>(prior.state)].data());
  }
  for (const BiasPrior& prior : data.bias_priors) {
    Vector6 value;
    Vector6 sigma;
    value << prior.bias.gyro, prior.bias.accel;
    sigma << prior.sigma.gyro, prior.sigma.accel;
    add(std::make_unique<VectorPriorFactor<6>>(value, sigma),
        biases_[static_cast<std::size_t>(prior.state)].data());
  }
}

void GraphProblem::add_global_priors(const GraphData& data) {
  const auto add = [this](std::unique_ptr<ceres::CostFunction> factor, double* block) {
    priors_.push_back(std::move(factor));
    problem_->AddResidualBlock(priors_.back().get(), nullptr, block);
  };
  const auto add_scalar = [&add](const ScalarPrior& prior, double* block) {
    using Scalar = Eigen::Matrix<double, 1, 1>;
    add(std::make_unique<VectorPriorFactor<1>>(Scalar(prior.value), Scalar(prior.sigma)), block);
  };
  for (const GravityPrior& prior : data.gravity_priors) {
    add(std::make_unique<VectorPriorFactor<3>>(prior.direction,
                                               Eigen::Vector3d::Constant(prior.sigma)),
        gravity_direction_.data());
  }
  for (const ScalarPrior& prior : data.disparity_offset_priors) {
    add_scalar(prior, &disparity_offset_);
  }
  for (const ScalarPrior& prior : data.focal_error_priors) add_scalar(prior, &focal_error_);
  for (const ScalarPrior& prior : data.time_offset_priors) add_scalar(prior, &time_offset_s_);
  for (const RotationPrior& prior : data.camera_rotation_priors) {
    add(std::make_unique<VectorPriorFactor<3>>(prior.value, Eigen::Vector3d::Constant(prior.sigma)),
        camera_rotation_.data());
  }
  for (const ShapePrior& prior : data.gyro_shape_priors) {
    const RowMajor3 rows = prior.value;
    add(std::make_unique<VectorPriorFactor<9>>(Eigen::Map<const Vector9>(rows.data()),
                                               Vector9::Constant(prior.sigma)),
        gyro_shape_.data());
  }
}

void GraphProblem::add_marginal_prior(const GraphData& data) {
  if (data.marginal.empty()) return;
  std::vector<double*> blocks;
  for (const BlockId& id : data.marginal.blocks) blocks.push_back(block(id));
  priors_.push_back(std::make_unique<MarginalPriorFactor>(data.marginal));
  problem_->AddResidualBlock(priors_.back().get(), nullptr, blocks);
}

void GraphProblem::set_manifolds() {
  for (auto& pose : poses_) {
    if (problem_->HasParameterBlock(pose.data())) {
      problem_->SetManifold(pose.data(), &pose_manifold_);
    }
  }
  if (problem_->HasParameterBlock(gravity_direction_.data())) {
    problem_->SetManifold(gravity_direction_.data(), &direction_manifold_);
  }
}

void GraphProblem::hold_globals() {
  const auto hold = [this](double* block, bool estimate) {
    if (!estimate && problem_->HasParameterBlock(block)) problem_->SetParameterBlockConstant(block);
  };
  hold(gravity_direction_.data(), options_.estimate_gravity);
  hold(&disparity_offset_, options_.estimate_disparity_offset);
  hold(&focal_error_, options_.estimate_focal_error);
  hold(&time_offset_s_, options_.estimate_time_offset);
  hold(camera_rotation_.data(), options_.estimate_camera_rotation);
  hold(gyro_shape_.data(), options_.estimate_gyro_shape);
}

double* GraphProblem::block(const BlockId& id) {
  const auto i = static_cast<std::size_t>(id.state);
  switch (id.kind) {
    case BlockId::Kind::kPose:
      return poses_[i].data();
    case BlockId::Kind::kVelocity:
      return velocities_[i].data();
    case BlockId::Kind::kBias:
      return biases_[i].data();
    case BlockId::Kind::kGravity:
      return gravity_direction_.data();
    case BlockId::Kind::kDisparityOffset:
      return &disparity_offset_;
    case BlockId::Kind::kFocalError:
      return &focal_error_;
    case BlockId::Kind::kTimeOffset:
      return &time_offset_s_;
    case BlockId::Kind::kCameraRotation:
      return camera_rotation_.data();
    case BlockId::Kind::kGyroShape:
      return gyro_shape_.data();
  }
  throw ContractError("unknown kind of block");
}

bool GraphProblem::estimated(const BlockId& id) {
  const double* values = block(id);
  return problem_->HasParameterBlock(values) && !problem_->IsParameterBlockConstant(values);
}

bool GraphProblem::store(GraphData& data) const {
  const Eigen::Map<const Eigen::Vector3d> gravity(gravity_direction_.data());
  const Eigen::Map<const Eigen::Vector3d> camera_rotation(camera_rotation_.data());
  const Eigen::Map<const RowMajor3> gyro_shape(gyro_shape_.data());
  if (!all_finite(poses_) || !all_finite(velocities_) || !all_finite(biases_) ||
      !gravity.allFinite() || !std::isfinite(disparity_offset_) || !std::isfinite(focal_error_) ||
      !std::isfinite(time_offset_s_) || !camera_rotation.allFinite() || !gyro_shape.allFinite()) {
    return false;
  }
  for (std::size_t i = 0; i < data.states.size(); ++i) {
    State& state = data.states[i];
    state.nav.T_world_body = pose_from_block(poses_[i].data());
    state.nav.v_world = Eigen::Map<const Eigen::Vector3d>(velocities_[i].data());
    state.bias.gyro = Eigen::Map<const Eigen::Vector3d>(biases_[i].data());
    state.bias.accel = Eigen::Map<const Eigen::Vector3d>(biases_[i].data() + 3);
  }
  data.globals.gravity_direction = gravity.normalized();
  data.globals.disparity_offset = disparity_offset_;
  data.globals.focal_error = focal_error_;
  data.globals.time_offset_s = time_offset_s_;
  data.globals.camera_rotation = camera_rotation;
  data.globals.gyro_shape = gyro_shape;
  return true;
}

}  // namespace imslam::pgo
