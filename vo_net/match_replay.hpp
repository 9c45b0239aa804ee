#pragma once

#include "slam/sensors/stereo.hpp"
#include "vo_net/match_network.hpp"
#include "vo_net/matcher.hpp"

namespace imslam::vo {

/// The two pairs of a motion and how the network searched them.
struct ReplayImages {
  const GrayImage* left0 = nullptr;
  const GrayImage* right0 = nullptr;
  const GrayImage* left1 = nullptr;
  const GrayImage* right1 = nullptr;
  MatchSearch search;
};

/// The network's three answers about each correspondence, in pixels of the network.
struct ReplayedMatch {
  NetworkMatch flow;     ///< from left0 to left1, at left0
  NetworkMatch stereo0;  ///< from left0 to right0, at left0
  NetworkMatch stereo1;  ///< from left1 to right1, at left1
  int shrink = 1;
};

/// Asks the network once more what it said about these correspondences, this time on a tape that
/// remembers how to go back. The points and the search are those of then; where they came from has
/// no derivative. `network` must not be folded; its norms should be frozen.
template <typename S>
ReplayedMatch replay_match(nn::Tape<S>& tape,
                           MatchNetwork<S>& network,
                           const ReplayImages& images,
                           const Correspondences& correspondences);

/// The correspondences with the network's present numbers wherever those were the network's own;
/// weights always.
template <typename S>
Correspondences replayed(const nn::Tape<S>& tape,
                         const ReplayedMatch& match,
                         const Correspondences& correspondences,
                         double sigma_floor);

}  // namespace imslam::vo
