#include "slam/system/resting_frames.hpp"

#include <cmath>

#include "slam/base/time.hpp"

namespace imslam::system {
namespace {

constexpr std::int64_t kHalfWindow_ns = 250'000'000;
constexpr double kShortest_s = 0.5;  // vision cannot judge a rest that is shorter
constexpr double kLongest_s = 2.0;   // and a longer one is judged in pieces, lest it hide a journey
constexpr double kFast = 5.0;        // of sigma: no rest, whatever follows
constexpr double kNowhere = 0.3;     // of the way that sigma allows

/// Motions in a row that may be a rest.
struct Piece {
  std::vector<std::size_t> frames;
  std::int64_t time0_ns = 0;
  std::int64_t time1_ns = 0;
  lie::SE3d T_begin_end;
  double variance = 0.0;  ///< [m^2] of the way, by vision's own account

  double span_s() const { return frames.empty() ? 0.0 : to_seconds(time1_ns - time0_ns); }

  void add(const RelativeMotion& motion, std::size_t frame) {
    if (frames.empty()) time0_ns = motion.time0_ns;
    time1_ns = motion.time1_ns;
    T_begin_end = T_begin_end * motion.T_body0_body1;
    variance += motion.covariance.topLeftCorner<3, 3>().trace();
    frames.push_back(frame);
  }
  bool rests(double sigma) const {
    const double nowhere = kNowhere * sigma * span_s() + std::sqrt(variance);
    return span_s() >= kShortest_s && T_begin_end.translation().norm() < nowhere;
  }
};

bool imu_rests(const Measurements& measurements,
               std::int64_t time_ns,
               const imu::StaticDetectorOptions& still) {
  const std::int64_t from_ns = time_ns - kHalfWindow_ns;
  const std::int64_t to_ns = time_ns + kHalfWindow_ns;
  return imu::assess_stillness(measurements.readings().around(from_ns, to_ns), from_ns, to_ns,
                               measurements.imu_noise, still)
      .still;
}

}  // namespace

std::vector<std::size_t> resting_frames(const Measurements& measurements,
                                        double sigma,
                                        const imu::StaticDetectorOptions& still) {
  std::vector<std::size_t> resting;
  Piece piece;
  const auto finish = [&] {
    if (piece.rests(sigma)) {
      resting.insert(resting.end(), piece.frames.begin(), piece.frames.end());
    }
    piece = {};
  };
  for (const RelativeMotion& motion : measurements.odometry) {
    const double dt_s = to_seconds(motion.time1_ns - motion.time0_ns);
    const auto frame = measurements.frame_at(motion.time1_ns);
    const bool slow = motion.T_body0_body1.translation().norm() < kFast * sigma * dt_s;
    const bool rests = slow && frame && imu_rests(measurements, motion.time1_ns, still);
    const bool goes_on = piece.frames.empty() || motion.time0_ns == piece.time1_ns;
    if (!rests || !goes_on) finish();
    if (rests) piece.add(motion, *frame);
    if (piece.span_s() >= kLongest_s) finish();
  }
  finish();
  return resting;
}

}  // namespace imslam::system
