#include "slam/training/truth_bend.hpp"

#include "imu_net/preintegration.hpp"

namespace imslam::training {

Bend bend(imu::ImuRange samples,
          const ImuNoise& noise,
          const Trajectory& truth,
          const PoseTriple& triple,
          const ImuBias& bias,
          const Eigen::Vector3d& gravity) {
  const auto pose = [&](std::size_t k) -> const lie::SE3d& { return truth.poses[triple[k]]; };
  const auto motion = [&](std::size_t from) {
    return imu::preintegrate(samples, truth.times_ns[triple[from]],
                             truth.times_ns[triple[from + 1]], bias, noise);
  };
  const ImuMotion m1 = motion(0);
  const ImuMotion m2 = motion(1);
  const double T1 = m1.dt_s;
  const double T2 = m2.dt_s;
  const Eigen::Matrix3d R0 = pose(0).rotation().matrix();
  const Eigen::Matrix3d R1 = pose(1).rotation().matrix();
  const double gravity_weight = T2 * (T1 + T2) / 2.0;
  const Eigen::Vector3d from_imu = T2 * (R0 * (m1.dv - m1.dp / T1)) + R1 * m2.dp;
  Bend result;
  result.usable = m1.valid && m2.valid && !m1.degraded && !m2.degraded;
  result.residual.head<3>() =
      (m1.dR.inverse() * pose(0).rotation().inverse() * pose(1).rotation()).log();
  result.residual.tail<3>() = pose(2).translation() - pose(1).translation() -
                              T2 / T1 * (pose(1).translation() - pose(0).translation()) -
                              gravity_weight * gravity - from_imu;
  result.J << -m1.J_dR_bias, Eigen::Matrix3d::Zero(),
      -T2 * R0 * (m1.J_dv_bias - m1.J_dp_bias / T1) - R1 * m2.J_dp_bias,
      -gravity_weight * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 6, 9> G1 = Eigen::Matrix<double, 6, 9>::Zero();
  G1.topLeftCorner<3, 3>().setIdentity();
  G1.block<3, 3>(3, 3) = T2 * R0;
  G1.block<3, 3>(3, 6) = -T2 / T1 * R0;
  result.covariance = G1 * m1.covariance * G1.transpose();
  result.covariance.bottomRightCorner<3, 3>() +=
      R1 * m2.covariance.bottomRightCorner<3, 3>() * R1.transpose();
  return result;
}

}  // namespace imslam::training
