#pragma once

#include "slam/nn/tensor.hpp"
#include "slam/plugins/routing/instance.hpp"

namespace imslam::routing {

/// Cities as the network sees them, the depot first, the others in their order  [n, kCityFeatures]
///
///   lengths      in the unit of the larger side of the field
///   directions   seen from the depot, turned so that the middle of all cities lies ahead
///   ranks        in [-1/2, 1/2]: how many of the cities are nearer, how many further to the right
///   work         log of the length of a tour through all cities of such a field
///
/// Ranks and work tell how much there is to do, which places alone do not: the more cities, the
/// less a long way out counts. Moved, turned or scaled fields look the same but for the place in
/// the box around them.
inline constexpr int kCityFeatures = 15;
nn::Tensor<float> city_features(const Instance& instance);

}  // namespace imslam::routing
