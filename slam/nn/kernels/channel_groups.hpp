#pragma once

#include <algorithm>

namespace imslam::nn::kernels {

/// Output channels that one tile computes together.
struct ChannelGroup {
  int first_channel = 0;
  int first_packet = 0;
  int packets = 0;
  int last_lanes = 0;  ///< used lanes of the last packet
};

/// Cuts channels into groups of almost equal numbers of packets.
class ChannelGroups {
 public:
  ChannelGroups(int channels, int lanes, int most_packets)
      : channels_(channels),
        lanes_(lanes),
        packets_((channels + lanes - 1) / lanes),
        count_((packets_ + most_packets - 1) / most_packets) {}

  int count() const { return count_; }
  int lanes() const { return lanes_; }
  /// Channels rounded up to whole packets.
  int padded() const { return packets_ * lanes_; }

  ChannelGroup group(int index) const {
    ChannelGroup group;
    const int larger = packets_ % count_;
    group.first_packet = index * (packets_ / count_) + std::min(index, larger);
    group.packets = packets_ / count_ + (index < larger ? 1 : 0);
    group.first_channel = group.first_packet * lanes_;
    const int last_begin = group.first_channel + (group.packets - 1) * lanes_;
    group.last_lanes = std::min(lanes_, channels_ - last_begin);
    return group;
  }

 private:
  int channels_, lanes_, packets_, count_;
};

}  // namespace imslam::nn::kernels
