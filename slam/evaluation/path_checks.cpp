#include "slam/evaluation/path_checks.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/evaluation/align.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

namespace imslam::evaluation {
namespace {

constexpr double kLargestDefect = 1e-3;
constexpr double kFlat = 1e-6;  ///< ratio of variances: 1 mm on 1 m
constexpr double kSuspiciousAngle = 20.0 / kDegreesPerRadian;
constexpr double kSureOfAlignment = 3.0;  ///< angles below as many of its standard deviations

struct MeanRotation {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  double spread = 0.0;  ///< rms angle to the mean [rad]
};

/// The quaternion nearest to all: the largest eigenvector of sum q q^T (Markley 2007), which does
/// not care about the signs of the quaternions.
MeanRotation mean_rotation(const std::vector<Eigen::Matrix3d>& rotations) {
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  for (const Eigen::Matrix3d& R : rotations) {
    const Eigen::Vector4d q = quaternion_of(R).coeffs();
    M += q * q.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(M);
  MeanRotation mean;
  mean.R = Eigen::Quaterniond(Eigen::Vector4d(solver.eigenvectors().col(3))).toRotationMatrix();
  double sum = 0.0;
  for (const Eigen::Matrix3d& R : rotations) {
    const double angle = rotation_angle(mean.R.transpose() * R);
    sum += angle * angle;
  }
  mean.spread = std::sqrt(sum / static_cast<double>(rotations.size()));
  return mean;
}

/// How well positions determine the turn about the path's main direction [rad]: what is left of
/// them after alignment, seen from how far the path goes aside.
double alignment_sigma(const PosePath& aligned, const PosePath& reference) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto count = static_cast<double>(reference.size());
  for (const Eigen::Matrix4d& pose : reference.poses) mean += position(pose) / count;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  double left = 0.0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const Eigen::Vector3d d = position(reference.poses[i]) - mean;
    spread += d * d.transpose() / count;
    left += (position(aligned.poses[i]) - position(reference.poses[i])).squaredNorm() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread, Eigen::EigenvaluesOnly);
  const double aside = axes.eigenvalues()[0] + axes.eigenvalues()[1];
  return aside > 0.0 ? std::sqrt(left / aside) : M_PI;
}

std::string constant_rotation_warning(const MatchedPaths& matched, const PosePath& aligned) {
  std::vector<Eigen::Matrix3d> differences;
  for (std::size_t i = 0; i < aligned.size(); ++i) {
    differences.push_back(rotation(aligned.poses[i]).transpose() *
                          rotation(matched.reference.poses[i]));
  }
  const MeanRotation mean = mean_rotation(differences);
  const double angle = rotation_angle(mean.R);
  if (angle < kSuspiciousAngle || mean.spread > 0.25 * angle) return "";
  if (angle < kSureOfAlignment * alignment_sigma(aligned, matched.reference)) return "";
  const Eigen::Quaterniond q = quaternion_of(mean.R);
  return fmt::format(
      "the frames differ: after alignment the orientations are {:.1f} deg apart, always about the "
      "same (spread {:.1f} deg), as if {} were poses of a camera and {} of a body or the other way "
      "round; give the transform with --T-body-eval (rotation near qx qy qz qw = {:.4f} {:.4f} "
      "{:.4f} {:.4f})",
      angle * kDegreesPerRadian, mean.spread * kDegreesPerRadian, matched.estimate.source,
      matched.reference.source, q.x(), q.y(), q.z(), q.w());
}

}  // namespace

void require_evaluable(const PosePath& path) {
  const auto fail = [&](std::size_t i, const std::string& what) {
    throw InputError(fmt::format("{}: pose {}: {}", path.source, i + 1, what),
                     ExitCode::kEvaluation);
  };
  if (path.size() == 0) throw InputError(path.source + ": holds no poses", ExitCode::kEvaluation);
  expects(!path.has_stamps() || path.stamps_s.size() == path.size(),
          "PosePath: as many stamps as poses, or none");
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path.has_stamps() && !std::isfinite(path.stamps_s[i])) fail(i, "the stamp is not finite");
    if (!path.poses[i].allFinite()) fail(i, "not finite; remove it or find out why it was written");
    const double defect = rotation_defect(rotation(path.poses[i]));
    if (defect > kLargestDefect) {
      fail(i, fmt::format("the rotation matrix is not orthonormal (off by {:.2g})", defect));
    }
  }
}

PosePath moved_to_frame(const PosePath& path, const Eigen::Matrix4d& T_body_eval) {
  PosePath moved = path;
  for (Eigen::Matrix4d& pose : moved.poses) pose = pose * T_body_eval;
  return moved;
}

std::vector<std::string> frame_warnings(const MatchedPaths& matched) {
  std::vector<std::string> warnings;
  const PosePath& reference = matched.reference;
  const PosePath& estimate = matched.estimate;
  const bool labels_differ =
      !reference.frame.empty() && !estimate.frame.empty() && reference.frame != estimate.frame;
  if (labels_differ) {
    warnings.push_back(fmt::format(
        "the frames differ: {} has poses of '{}', {} of '{}'; carry the estimate over with "
        "--T-body-eval",
        reference.source, reference.frame, estimate.source, estimate.frame));
  }
  Similarity fit;
  try {
    fit = umeyama(positions_of(estimate), positions_of(reference), false);
  } catch (const InputError&) {
    return warnings;  // the alignment itself reports it where it is asked for
  }
  if (fit.flatness < kFlat) {
    warnings.emplace_back(
        "the path is a nearly straight line: alignment by positions leaves the rotation about it "
        "open, so rotation errors after alignment mean little");
    return warnings;
  }
  const std::string doubt = constant_rotation_warning(matched, transformed(estimate, fit));
  if (!doubt.empty() && !labels_differ) warnings.push_back(doubt);
  return warnings;
}

}  // namespace imslam::evaluation
