#include "slam/evaluation/align.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "slam/base/error.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

// LAPACK's divide-and-conquer SVD, column major.
extern "C" void dgesdd_(const char* job,
                        const int* rows,
                        const int* columns,
                        double* A,
                        const int* stride_A,
                        double* singular_values,
                        double* U,
                        const int* stride_U,
                        double* V_transposed,
                        const int* stride_V,
                        double* work,
                        const int* work_size,
                        int* integer_work,
                        int* info);

namespace imslam::evaluation {
namespace {

struct Svd {
  Eigen::Matrix3d U;
  Eigen::Vector3d d;
  Eigen::Matrix3d V_transposed;
};

/// The routine that stands behind numpy's svd: with another one the rotation differs in its last
/// digit, and with coordinates of kilometres that shows in the ninth digit of the least errors.
Svd singular_value_decomposition(Eigen::Matrix3d A) {
  constexpr int kSize = 3;
  constexpr int kWorkSize = 256;
  std::array<double, kWorkSize> work{};
  std::array<int, 8 * kSize> integer_work{};
  Svd svd;
  int info = 0;
  dgesdd_("A", &kSize, &kSize, A.data(), &kSize, svd.d.data(), svd.U.data(), &kSize,
          svd.V_transposed.data(), &kSize, work.data(), &kWorkSize, integer_work.data(), &info);
  if (info != 0) {
    throw InputError("the SVD of the positions did not converge; alignment is not possible",
                     ExitCode::kEvaluation);
  }
  return svd;
}

struct Moments {
  Eigen::Vector3d mean_x = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_y = Eigen::Vector3d::Zero();
  double variance_x = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of y against x
  double extent = 0.0;  ///< largest coordinate: sets the size of rounding errors
};

Moments moments(const Points& x, const Points& y) {
  expects(x.size() == y.size() && !x.empty(), "align: paths must be paired and not empty");
  const auto n = static_cast<double>(x.size());
  Moments m;
  for (std::size_t i = 0; i < x.size(); ++i) {
    m.mean_x += x[i];
    m.mean_y += y[i];
    m.extent = std::max({m.extent, x[i].cwiseAbs().maxCoeff(), y[i].cwiseAbs().maxCoeff()});
  }
  m.mean_x /= n;
  m.mean_y /= n;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector3d dx = x[i] - m.mean_x;
    m.variance_x += dx.squaredNorm();
    m.covariance += (y[i] - m.mean_y) * dx.transpose();
  }
  m.variance_x /= n;
  m.covariance /= n;
  return m;
}

/// evo asks for two singular values above the machine epsilon. Positions far from the origin carry
/// larger rounding errors than that, which would pass for a second direction: hence the second
/// bound.
double rank_threshold(const Moments& m, double largest_singular_value) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  return kEpsilon * std::max(1.0, 4.0 * m.extent * std::sqrt(largest_singular_value));
}

Eigen::Matrix3d rotation_to_z(const Eigen::Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(up.normalized(), Eigen::Vector3d::UnitZ())
      .toRotationMatrix();
}

Points first_of(Points points, std::size_t count) {
  if (count > 0 && count < points.size()) points.resize(count);
  return points;
}

Similarity origin_fit(const PosePath& reference, const PosePath& estimate) {
  const Eigen::Matrix4d T = reference.poses.front() * rigid_inverse(estimate.poses.front());
  Similarity transform;
  transform.R = rotation(T);
  transform.t = position(T);
  return transform;
}

}  // namespace

Eigen::Matrix4d Similarity::matrix() const { return rigid(scale * R, t); }

Points positions_of(const PosePath& path) {
  Points points;
  points.reserve(path.size());
  for (const Eigen::Matrix4d& T : path.poses) points.push_back(position(T));
  return points;
}

Similarity umeyama(const Points& x, const Points& y, bool with_scale) {
  const Moments m = moments(x, y);
  const Svd svd = singular_value_decomposition(m.covariance);
  const Eigen::Vector3d& d = svd.d;
  if (d(1) <= rank_threshold(m, d(0))) {
    throw InputError("Degenerate covariance rank, Umeyama alignment is not possible",
                     ExitCode::kEvaluation);
  }
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.U.determinant() * svd.V_transposed.determinant() < 0.0) signs.z() = -1.0;

  Similarity result;
  result.R = svd.U * signs.asDiagonal() * svd.V_transposed;
  if (with_scale) result.scale = d.dot(signs) / m.variance_x;
  result.t = m.mean_y - result.scale * (result.R * m.mean_x);
  result.flatness = d(1) / d(0);
  return result;
}

Similarity fit_position_and_yaw(const Points& x, const Points& y, const AlignmentOptions& options) {
  const Moments m = moments(x, y);
  const Eigen::Matrix3d R_z_x = rotation_to_z(options.up_estimate);
  const Eigen::Matrix3d R_z_y = rotation_to_z(options.up_reference);
  const Eigen::Matrix3d K = R_z_x * m.covariance.transpose() * R_z_y.transpose();
  const double theta = std::atan2(K(0, 1) - K(1, 0), K(0, 0) + K(1, 1));

  Similarity result;
  result.R = R_z_y.transpose() *
             Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitZ()).toRotationMatrix() * R_z_x;
  result.t = m.mean_y - result.R * m.mean_x;
  return result;
}

PosePath transformed(const PosePath& path, const Similarity& transform) {
  PosePath result = path;
  const Eigen::Matrix4d T = rigid(transform.R, transform.t);
  for (Eigen::Matrix4d& pose : result.poses) {
    pose.topRightCorner<3, 1>() *= transform.scale;
    pose = T * pose;
  }
  return result;
}

AlignedPath align(const PosePath& reference,
                  const PosePath& estimate,
                  const AlignmentOptions& options) {
  expects(reference.size() == estimate.size() && reference.size() > 0,
          "align: paths must be paired and not empty");
  if (options.kind == Alignment::kNone) return {estimate, Similarity{}};
  if (options.kind == Alignment::kOrigin) {
    const Similarity transform = origin_fit(reference, estimate);
    return {transformed(estimate, transform), transform};
  }
  const Points x = first_of(positions_of(estimate), options.first);
  const Points y = first_of(positions_of(reference), options.first);
  if (options.kind == Alignment::kPosYaw) {
    const Similarity transform = fit_position_and_yaw(x, y, options);
    return {transformed(estimate, transform), transform};
  }
  const Similarity transform = umeyama(x, y, options.kind != Alignment::kSe3);
  Similarity applied = transform;
  if (options.kind == Alignment::kScale) {
    applied.R.setIdentity();
    applied.t.setZero();
  }
  return {transformed(estimate, applied), transform};
}

}  // namespace imslam::evaluation
