#pragma once

#include "slam/nn/tensor.hpp"
#include "slam/plugins/routing/allocation_problem.hpp"

namespace imslam::routing {

struct SurrogateFeatures {
  nn::Tensor<float> pairs;  ///< [cities * agents, SurrogateNetwork::kPairFeatures]
  nn::Tensor<float> whole;  ///< [1, SurrogateNetwork::kWholeFeatures]
};

/// `probabilities` cities x agents, of all cities but the depot. The instance needs coordinates.
SurrogateFeatures surrogate_features(const Instance& instance,
                                     const learner::Matrix& probabilities);

}  // namespace imslam::routing
