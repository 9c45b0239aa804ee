#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// A view of samples in increasing order of time; the samples must outlive it.
class ImuRange {
 public:
  ImuRange() = default;
  ImuRange(const ImuSample* first, const ImuSample* last) : first_(first), last_(last) {}
  // A vector is a range: callers may hand over what they have.
  ImuRange(const std::vector<ImuSample>& samples)  // NOLINT(google-explicit-constructor)
      : first_(samples.data()), last_(samples.data() + samples.size()) {}

  const ImuSample* begin() const { return first_; }
  const ImuSample* end() const { return last_; }
  std::size_t size() const { return static_cast<std::size_t>(last_ - first_); }
  bool empty() const { return first_ == last_; }
  const ImuSample& operator[](std::size_t i) const { return first_[i]; }

  /// The first sample later than `time_ns`, or end(). Binary search.
  const ImuSample* after(std::int64_t time_ns) const;

  /// The samples inside [time0_ns, time1_ns] and the nearest one on either side, as far as there
  /// are any: all that interpolation between the two times can need.
  ImuRange around(std::int64_t time0_ns, std::int64_t time1_ns) const;

 private:
  const ImuSample* first_ = nullptr;
  const ImuSample* last_ = nullptr;
};

/// Samples as they stream in, in order of time; old ones can be dropped so that memory stays
/// bounded however long the run is.
class ImuBuffer {
 public:
  ImuBuffer() = default;
  explicit ImuBuffer(const std::vector<ImuSample>& samples);

  /// False, and the sample is ignored, if it is not later than the newest one.
  bool append(const ImuSample& sample);

  /// Forgets samples older than `time_ns`, except the last of them (interpolation needs it).
  void drop_before(std::int64_t time_ns);

  /// All samples. Invalid after the next append() or drop_before().
  ImuRange samples() const;
  std::size_t size() const { return samples_.size() - start_; }
  bool empty() const { return size() == 0; }

 private:
  std::vector<ImuSample> samples_;
  std::size_t start_ = 0;  ///< dropped samples stay in front until they are worth a copy
};

}  // namespace imslam::imu
