#include "imu_net/imu_buffer.hpp"

#include <algorithm>

namespace imslam::imu {

const ImuSample* ImuRange::after(std::int64_t time_ns) const {
  return std::upper_bound(first_, last_, time_ns, [](std::int64_t time, const ImuSample& sample) {
    return time < sample.time_ns;
  });
}

ImuRange ImuRange::around(std::int64_t time0_ns, std::int64_t time1_ns) const {
  const ImuSample* first = after(time0_ns);
  if (first != first_) --first;
  const ImuSample* last = ImuRange(first, last_).after(time1_ns);
  // A sample exactly at the end is enough; otherwise the next one is needed.
  const bool exact = last != first && (last - 1)->time_ns == time1_ns;
  if (last != last_ && !exact) ++last;
  return {first, last};
}

ImuBuffer::ImuBuffer(const std::vector<ImuSample>& samples) {
  samples_.reserve(samples.size());
  for (const ImuSample& sample : samples) append(sample);
}

bool ImuBuffer::append(const ImuSample& sample) {
  if (!empty() && sample.time_ns <= samples_.back().time_ns) return false;
  samples_.push_back(sample);
  return true;
}

void ImuBuffer::drop_before(std::int64_t time_ns) {
  const auto older = static_cast<std::size_t>(samples().after(time_ns - 1) - samples_.data());
  if (older > start_ + 1) start_ = older - 1;
  if (start_ > samples_.size() / 2) {
    samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(start_));
    start_ = 0;
  }
}

ImuRange ImuBuffer::samples() const {
  return {samples_.data() + start_, samples_.data() + samples_.size()};
}

}  // namespace imslam::imu
