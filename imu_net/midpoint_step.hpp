#pragma once

#include <Eigen/Core>

#include "imu_net/symmetric_blocks.hpp"
#include "slam/lie/so3.hpp"

namespace imslam::imu {

/// The mean reading over a step, and the white noise it has.
struct StepInput {
  double h = 0.0;                                            ///< [s] length of the step
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();            ///< [rad/s], bias subtracted
  Eigen::Vector3d force = Eigen::Vector3d::Zero();           ///< [m/s^2], bias subtracted
  Eigen::Vector3d rate_variance = Eigen::Vector3d::Zero();   ///< density^2 / h per axis
  Eigen::Vector3d force_variance = Eigen::Vector3d::Zero();  ///< likewise
};

/// One step of the midpoint rule and its derivatives.
///
///   w = h rate,  E = Exp(w/2),  M = dR E,  a = M force
///   dR' = M E,   dv' = dv + h a,   dp' = dp + h dv + h^2/2 a
///
/// An error x = [dR dv dp], rotation on the right, becomes A x + B_rate d_rate + B_force d_force:
///
///       [ A_R      0   0 ]            [ h J_full     ]             [ 0        ]
///   A = [ A_v      I   0 ]   B_rate = [ h^2 J_half   ]   B_force = [ h M      ]
///       [ h/2 A_v  hI  I ]            [ h^3/2 J_half ]             [ h^2/2 M  ]
///
///   A_R = Exp(w)^T,  A_v = h F E^T,  J_full = Jr(w),  J_half = F Jr(w/2) / 2,  F = -M [force]x
struct MidpointStep {
  /// `dR`: the rotation that the step begins with.
  MidpointStep(const StepInput& input, const lie::SO3d& dR);

  lie::SO3d end() const { return middle * half; }  ///< dR'
  Eigen::Matrix<double, 9, 3> B_rate() const;
  Eigen::Matrix<double, 9, 3> B_force() const;

  /// X becomes A X.
  template <int Columns>
  void carry(Eigen::Matrix<double, 9, Columns>& X) const {
    const Eigen::Matrix<double, 3, Columns> top = X.template topRows<3>();
    const Eigen::Matrix<double, 3, Columns> turned = A_v * top;
    X.template bottomRows<3>() += 0.5 * in.h * turned + in.h * X.template middleRows<3>(3);
    X.template middleRows<3>(3) += turned;
    X.template topRows<3>().noalias() = A_R * top;
  }

  /// Sigma becomes A Sigma A^T + B_rate Q_rate B_rate^T + B_force Q_force B_force^T
  /// + [0 0 0; 0 0 0; 0 0 h^4/12 M Q_force M^T]; Q: the variances. The last term is white noise
  /// inside the step: its double integral has h^3/3 density^2, of which h^3/4 is in B_force.
  /// Returns the first three columns of A Sigma.
  Eigen::Matrix<double, 9, 3> carry_covariance(SymmetricBlocks& Sigma) const;

  StepInput in;
  lie::SO3d half, middle;  ///< E and M
  Eigen::Matrix3d E, M;
  Eigen::Matrix3d A_R, A_v;
  Eigen::Matrix3d J_full, Jr_half, J_half;  ///< Jr_half = Jr(w/2)
};

}  // namespace imslam::imu
