#pragma once

#include <Eigen/Core>

#include "imu_net/preintegration_record.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// dL/d(dR, dv, dp, covariance) of a motion.
struct MotionGradient {
  /// By [dR dv dp]; rotation: by theta of dR Exp(theta).
  Eigen::Matrix<double, 9, 1> motion = Eigen::Matrix<double, 9, 1>::Zero();
  /// dL = sum over all 81 entries of covariance(i, j) dSigma(i, j); its symmetric part counts.
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
};

/// dL/d(ImuSample); units: those of L over those of the field in ImuSample.
struct SampleGradient {
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear_acceleration = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_variance = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_variance = Eigen::Vector3d::Zero();
};

/// Reverse mode through preintegrate(), in closed form:
///
///   PreintegrationRecord record;
///   const ImuMotion motion = preintegrate(samples, ..., &record);
///   const ImuBias dL_dbias = add_preintegration_gradient(record, dL_dmotion, gradients.data());
///
/// Adds dL/d(samples[i]) to gradients[i]; only those of samples that were used are touched, so the
/// cost does not grow with the log. The samples handed to preintegrate() must still be there.
/// Returns dL/d(bias). Exact for dR, dv, dp and the covariance; only what gaps and bridged readings
/// add to the covariance (MidpointIntegrator::add_gap) is taken as a constant. A motion that is not
/// valid is constant. How the Jacobians of the motion depend on the samples is not followed.
ImuBias add_preintegration_gradient(const PreintegrationRecord& record,
                                    const MotionGradient& dL,
                                    SampleGradient* gradients);

}  // namespace imslam::imu
