#pragma once

#include <Eigen/Core>
#include <Eigen/StdVector>
#include <vector>

#include "vo_net/pose_layer.hpp"
#include "vo_net/pose_layer_point.hpp"

namespace imslam::vo::detail {

/// Where the solver stands: the pose of the *left* camera and every point's disparity.
struct Estimate {
  lie::SE3d T_left0_left1;
  std::vector<double> disparities;  ///< [px]
};

/// Pose tangent (6), disparity offset and focal error, the unknowns that remain.
using ReducedVector = Eigen::Matrix<double, 8, 1>;
using ReducedMatrix = Eigen::Matrix<double, 8, 8>;

/// What back-substitution needs of one point; zeros for a point that takes no part.
struct EliminatedPoint {
  ReducedVector coupling = ReducedVector::Zero();  ///< d2 cost / d(reduced) d(disparity)
  double curvature = 0.0;                          ///< d2 cost / d(disparity)^2, > 0 if it counts
  double gradient = 0.0;
  double s = 0.0;      ///< e^T Omega e
  double slope = 0.0;  ///< rho'(s)
  double bend = 0.0;   ///< rho''(s)
};

/// The quadratic model of the cost around an estimate, all disparities eliminated.
struct ReducedSystem {
  ReducedMatrix H = ReducedMatrix::Zero();
  ReducedVector g = ReducedVector::Zero();
  double cost = 0.0;
  double damping = 0.0;  ///< the diagonals of the disparities were multiplied by 1 + damping
  int used = 0;          ///< points in front of both cameras
  std::vector<EliminatedPoint> points;

  /// Adds -(H_dd (1 + damping))^-1 (g_d + coupling^T step) to every disparity.
  void back_substitute(const ReducedVector& step, std::vector<double>& d) const;
};

enum class Model { kGaussNewton, kExact };

struct Problem {
  const Correspondences& correspondences;
  const StereoCamera& camera;
  RobustKernel kernel = RobustKernel::kNone;
  double kernel_k2 = 1.0;
  double offset = 0.0;       ///< [px]
  std::vector<char> usable;  ///< finite, with sensible informations
};

/// The kernel bends at `noise_scale` times the option's width.
Problem make_problem(const Correspondences& correspondences,
                     const StereoCamera& camera,
                     const PoseLayerOptions& options,
                     double noise_scale,
                     double offset);

/// Which unknowns a quadratic model is to know. The calibration does not move while the solver
/// descends: without it a model costs half, and its rows and columns stay zero.
enum class Unknowns { kMotion, kMotionAndCalibration };

/// Gradient and 9x9 curvature of one point's cost 1/2 w rho(e^T Omega e).
struct PointModel {
  PointMatrix H;
  PointVector g;
  double cost = 0.0;
  double s = 0.0;
  KernelValue kernel;
};

PointModel model_point(const Problem& problem,
                       const Views& views,
                       const Correspondence& c,
                       const PointState& point,
                       Model model,
                       Unknowns unknowns = Unknowns::kMotionAndCalibration);

/// With Model::kExact a point whose exact curvature along its disparity is not positive falls back
/// to Gauss-Newton.
void build_system(const Problem& problem,
                  const Estimate& estimate,
                  Model model,
                  double damping,
                  ReducedSystem& system,
                  Unknowns unknowns = Unknowns::kMotion);

}  // namespace imslam::vo::detail
