#include "slam/system/slam_solver_steps.hpp"

#include "slam/base/error.hpp"

namespace imslam::system {
namespace {

using Vector = learner::Vector;
using SE3d = lie::SE3d;

/// ad(tau) x = [tau, x]
SE3d::Matrix6 bracket(const SE3d::Tangent& tau) {
  SE3d::Matrix6 ad = SE3d::Matrix6::Zero();
  ad.topLeftCorner<3, 3>() = lie::skew(tau.tail<3>());
  ad.bottomRightCorner<3, 3>() = ad.topLeftCorner<3, 3>();
  ad.topRightCorner<3, 3>() = lie::skew(tau.head<3>());
  return ad;
}

/// work(first entry) for the tangent of every pose; all else moves by addition.
template <typename Work>
void for_each_pose(const pgo::GraphPoint& point, const Work& work) {
  for (std::size_t b = 0; b < point.blocks().size(); ++b) {
    if (point.blocks()[b].kind == pgo::BlockId::Kind::kPose) work(point.offsets()[b]);
  }
}

}  // namespace

SlamSolverSteps::SlamSolverSteps(const pgo::GraphData& data,
                                 const pgo::GraphOptions& graph_options,
                                 const SlamUpperOptions& upper_options)
    : SlamLowerProblem(data, graph_options, {}, upper_options), first_guess_(point().numbers()) {
  expects(!graph_options.estimate_gravity, "slam solver steps: gravity must be held");
  expects(factorize(), "slam solver steps: the graph does not determine its states");
}

void SlamSolverSteps::go_to(const Vector& phi, const Vector& z) const {
  if (z.size() != this->z().size() || z != this->z()) {
    const std::string complaint = set_measurements(z);
    expects(complaint.empty(), "slam solver steps: measurements of no use");
  }
  movable_point().set_numbers(phi);
}

Vector SlamSolverSteps::step(const Vector& phi, const Vector& z) const {
  go_to(phi, z);
  movable_point().move(tau_of(-cost_by_phi()));
  return point().numbers();
}

SolveReport SlamSolverSteps::adopt(const Vector& phi, const Vector& z) {
  go_to(phi, z);
  SolveReport report;
  report.gradient_norm = cost_by_phi().lpNorm<Eigen::Infinity>();
  report.converged = take_states();
  return report;
}

learner::SolverSteps::StepGradient SlamSolverSteps::pull_back(const Vector& phi,
                                                              const Vector& z,
                                                              const Vector& dnext) const {
  go_to(phi, z);
  const Vector g = point().gradient();
  const Vector d = tau_of(-by_phi_of(g));
  Vector straight = by_tau_of(dnext);
  Vector turned = straight;
  for_each_pose(point(), [&](Eigen::Index at) {
    const SE3d::Tangent a = straight.segment<6>(at);
    turned.segment<6>(at) = SE3d::right_jacobian(d.segment<6>(at)).transpose() * a;
    straight.segment<6>(at) = SE3d::exp(-d.segment<6>(at)).adjoint().transpose() * a;
  });
  const Vector b = by_phi_of(turned);
  const Vector b_tau = tau_of(b);
  for_each_pose(point(), [&](Eigen::Index at) {
    straight.segment<6>(at) += bracket(b_tau.segment<6>(at)).transpose() * g.segment<6>(at);
  });
  return {by_phi_of(straight) - hessian_product(b), -mixed_product(b)};
}

}  // namespace imslam::system
