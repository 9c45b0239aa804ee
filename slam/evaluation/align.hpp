#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "slam/sensors/trajectory.hpp"

namespace imslam::evaluation {

/// How the estimate is laid over the reference before errors are taken.
enum class Alignment {
  kNone,
  kSe3,     ///< rotation and translation that fit the positions best
  kSim3,    ///< and a scale: for monocular odometry
  kScale,   ///< that scale only, without rotation and translation
  kOrigin,  ///< first pose onto first pose
  kPosYaw,  ///< heading and translation: roll and pitch are observable with an IMU
};

struct AlignmentOptions {
  Alignment kind = Alignment::kNone;
  std::size_t first = 0;  ///< fit to the first N pairs only; 0: to all
  Eigen::Vector3d up_reference = Eigen::Vector3d::UnitZ();  ///< vertical of its world, for kPosYaw
  Eigen::Vector3d up_estimate = Eigen::Vector3d::UnitZ();   ///< vertical of its world, for kPosYaw
};

/// y = scale R x + t, from the estimate's world to the reference's.
struct Similarity {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double scale = 1.0;
  /// Second over first singular value of the covariance of the positions: near 0 the path is a
  /// straight line and the rotation about it is not determined by positions.
  double flatness = 1.0;

  Eigen::Matrix4d matrix() const;  ///< [scale R, t; 0 1]
};

/// Columns of one path: n x 3 as a list.
using Points = std::vector<Eigen::Vector3d>;

Points positions_of(const PosePath& path);

/// argmin sum |y_i - (c R x_i + t)|^2. Source: Umeyama, "Least-Squares Estimation of Transformation
/// Parameters Between Two Point Patterns", PAMI 1991. c = 1 unless `with_scale`.
/// Throws InputError(kEvaluation), with evo's words, if the points do not determine R.
Similarity umeyama(const Points& x, const Points& y, bool with_scale);

/// argmin over rotations about the vertical and translations. With z up, K = sum of
/// (x_i - mu_x)(y_i - mu_y)^T:  theta = atan2(K12 - K21, K11 + K22). Source: Zhang and Scaramuzza,
/// "A Tutorial on Quantitative Trajectory Evaluation", IROS 2018.
Similarity fit_position_and_yaw(const Points& x, const Points& y, const AlignmentOptions& options);

struct AlignedPath {
  PosePath estimate;     ///< after the alignment
  Similarity transform;  ///< what was found (kScale: only its scale was applied)
};

/// The two paths are paired pose by pose. Scaling acts on positions before the rigid motion.
AlignedPath align(const PosePath& reference,
                  const PosePath& estimate,
                  const AlignmentOptions& options);

/// Applies p <- scale p, then P <- [R t; 0 1] P.
PosePath transformed(const PosePath& path, const Similarity& transform);

}  // namespace imslam::evaluation
