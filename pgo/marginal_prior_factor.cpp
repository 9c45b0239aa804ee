#include "pgo/marginal_prior_factor.hpp"

#include <ceres/sphere_manifold.h>

#include "pgo/pose_block.hpp"
#include "slam/base/error.hpp"

namespace imslam::pgo {
namespace {

using Kind = BlockId::Kind;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// x minus X and its derivative with respect to the numbers of x (tangent x block size).
void difference(Kind kind, const double* x, const double* X, double* delta, RowMajor* J) {
  const int size = block_size(kind);
  const int dof = tangent_size(kind);
  if (kind == Kind::kPose) {
    Eigen::Map<lie::SE3d::Tangent> tau(delta);
    tau = (pose_from_block(X).inverse() * pose_from_block(x)).log();
    if (J == nullptr) return;
    J->resize(dof, size);
    *J = lie::SE3d::right_jacobian_inverse(tau) * pose_minus_jacobian(x);
  } else if (kind == Kind::kGravity) {
    // Chart of the sphere at X: exact where the step is taken, first order in between.
    const ceres::SphereManifold<3> sphere;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> M;
    sphere.MinusJacobian(X, M.data());
    const Eigen::Map<const Eigen::Vector3d> n(x);
    const Eigen::Map<const Eigen::Vector3d> N(X);
    Eigen::Map<Eigen::Vector2d> tau(delta);
    tau = M * (n - N);
    if (J != nullptr) *J = M;
  } else {
    for (int i = 0; i < size; ++i) delta[i] = x[i] - X[i];
    if (J != nullptr) *J = RowMajor::Identity(dof, size);
  }
}

}  // namespace

int block_size(Kind kind) {
  switch (kind) {
    case Kind::kPose:
      return 7;
    case Kind::kVelocity:
    case Kind::kGravity:
    case Kind::kCameraRotation:
      return 3;
    case Kind::kBias:
      return 6;
    case Kind::kGyroShape:
      return 9;
    case Kind::kDisparityOffset:
    case Kind::kFocalError:
    case Kind::kTimeOffset:
      return 1;
  }
  throw ContractError("unknown kind of block");
}

int tangent_size(Kind kind) {
  if (kind == Kind::kPose) return 6;
  if (kind == Kind::kGravity) return 2;
  return block_size(kind);
}

MarginalPriorFactor::MarginalPriorFactor(const MarginalPrior& prior) : prior_(prior) {
  expects(prior.blocks.size() == prior.point.size() && prior.J.rows() == prior.residual.size(),
          "marginal prior: blocks, point, J and residual must fit");
  for (const BlockId& id : prior.blocks) {
    mutable_parameter_block_sizes()->push_back(block_size(id.kind));
  }
  set_num_residuals(static_cast<int>(prior.residual.size()));
}

bool MarginalPriorFactor::Evaluate(double const* const* parameters,
                                   double* residuals,
                                   double** jacobians) const {
  Eigen::Map<Eigen::VectorXd> r(residuals, prior_.residual.size());
  r = prior_.residual;
  RowMajor J_difference;
  Eigen::Index column = 0;
  for (std::size_t i = 0; i < prior_.blocks.size(); ++i) {
    const Kind kind = prior_.blocks[i].kind;
    const bool wanted = jacobians != nullptr && jacobians[i] != nullptr;
    double delta[9];
    difference(kind, parameters[i], prior_.point[i].data(), delta,
               wanted ? &J_difference : nullptr);
    const int dof = tangent_size(kind);
    const auto J = prior_.J.middleCols(column, dof);
    r += J * Eigen::Map<const Eigen::VectorXd>(delta, dof);
    if (wanted) {
      Eigen::Map<RowMajor>(jacobians[i], r.size(), block_size(kind)) = J * J_difference;
    }
    column += dof;
  }
  return r.allFinite();
}

}  // namespace imslam::pgo
