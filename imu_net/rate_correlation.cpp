// The coarse stage of gyro_alignment.hpp.
#include <algorithm>
#include <cmath>

#include "imu_net/gyro_alignment.hpp"
#include "imu_net/sample_health.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

/// Integral of the gyro's reading since the first sample; rotations within one camera interval are
/// small enough to be added up.
class AngleTable {
 public:
  AngleTable(ImuRange samples, const ImuNoise& noise) {
    for (const ImuSample& sample : samples) {
      if (sample_health(sample, noise) != SampleHealth::kGood) continue;
      if (!times_ns_.empty() && sample.time_ns <= times_ns_.back()) continue;
      Eigen::Vector3d angle = Eigen::Vector3d::Zero();
      if (!times_ns_.empty()) {
        const double h = to_seconds(sample.time_ns - times_ns_.back());
        angle = angles_.back() + 0.5 * h * (last_rate_ + sample.angular_velocity);
      }
      last_rate_ = sample.angular_velocity;
      times_ns_.push_back(sample.time_ns);
      angles_.push_back(angle);
    }
  }

  bool covers(std::int64_t time0_ns, std::int64_t time1_ns) const {
    return times_ns_.size() > 1 && times_ns_.front() <= time0_ns && time1_ns < times_ns_.back();
  }

  Eigen::Vector3d at(std::int64_t time_ns) const {
    const auto next = std::upper_bound(times_ns_.begin(), times_ns_.end(), time_ns);
    const auto i = static_cast<std::size_t>(next - times_ns_.begin());
    const double share = static_cast<double>(time_ns - times_ns_[i - 1]) /
                         static_cast<double>(times_ns_[i] - times_ns_[i - 1]);
    return angles_[i - 1] + share * (angles_[i] - angles_[i - 1]);
  }

 private:
  std::vector<std::int64_t> times_ns_;
  std::vector<Eigen::Vector3d> angles_;
  Eigen::Vector3d last_rate_ = Eigen::Vector3d::Zero();
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct RateStep {
  std::int64_t time0_ns, time1_ns;
  Eigen::Vector3d rate;  ///< vision's mean angular velocity [rad/s]
};

/// Mean absolute difference of the rates once the median of each axis, the bias, is gone.
double disagreement(const std::vector<RateStep>& steps,
                    const AngleTable& angles,
                    std::int64_t offset_ns) {
  double sum = 0.0;
  std::vector<std::vector<double>> differences(3, std::vector<double>(steps.size()));
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Eigen::Vector3d turned =
        angles.at(steps[k].time1_ns + offset_ns) - angles.at(steps[k].time0_ns + offset_ns);
    const double dt = to_seconds(steps[k].time1_ns - steps[k].time0_ns);
    for (int axis = 0; axis < 3; ++axis) {
      differences[static_cast<std::size_t>(axis)][k] = turned(axis) / dt - steps[k].rate(axis);
    }
  }
  for (const std::vector<double>& axis : differences) {
    const double bias = median(axis);
    for (const double value : axis) sum += std::abs(value - bias);
  }
  return sum / static_cast<double>(steps.size());
}

}  // namespace

std::optional<double> search_time_offset(const std::vector<RelativeMotion>& vision,
                                         ImuRange samples,
                                         const ImuNoise& noise,
                                         const GyroAlignmentOptions& options) {
  const AngleTable angles(samples, noise);
  const std::int64_t reach_ns = to_nanoseconds(options.max_time_offset_s);
  std::vector<RateStep> steps;
  for (const RelativeMotion& motion : vision) {
    if (!motion.valid || motion.time1_ns <= motion.time0_ns) continue;
    if (!angles.covers(motion.time0_ns - reach_ns, motion.time1_ns + reach_ns)) continue;
    const double dt = to_seconds(motion.time1_ns - motion.time0_ns);
    const Eigen::Vector3d rate = motion.T_body0_body1.rotation().log() / dt;
    if (rate.allFinite()) steps.push_back({motion.time0_ns, motion.time1_ns, rate});
  }
  if (static_cast<int>(steps.size()) < options.min_motions) return std::nullopt;

  const int reach = static_cast<int>(options.max_time_offset_s / options.search_step_s);
  double best_offset_s = 0.0;
  double best = disagreement(steps, angles, 0);  // zero wins a tie: nothing moved
  for (int i = -reach; i <= reach; ++i) {
    const double offset_s = i * options.search_step_s;
    const double value = disagreement(steps, angles, to_nanoseconds(offset_s));
    if (value < best) {
      best = value;
      best_offset_s = offset_s;
    }
  }
  return best_offset_s;
}

}  // namespace imslam::imu
