#pragma once

#include <vector>

#include "slam/training/flow_fields.hpp"
#include "vo_net/pose_head_loss.hpp"

namespace imslam::training {

/// Flow fields as the pose head sees them, and their truth.
struct PoseHeadSample {
  nn::Tensor<float> grids;  ///< [N,H,W,5], see vo::FlowGrid
  vo::PoseHeadTruth<float> truth;
};

PoseHeadSample pose_head_sample(const std::vector<FlowField>& fields);

}  // namespace imslam::training
