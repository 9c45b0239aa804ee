#include "slam/training/pose_head_sample.hpp"

#include "vo_net/flow_grid.hpp"

namespace imslam::training {

PoseHeadSample pose_head_sample(const std::vector<FlowField>& fields) {
  const auto count = static_cast<nn::Index>(fields.size());
  PoseHeadSample sample;
  sample.grids = vo::FlowGrid::make(count);
  sample.truth.rotation = nn::Tensor<float>({count, 3});
  sample.truth.direction = nn::Tensor<float>({count, 3});
  sample.truth.moves = nn::Tensor<float>({count, 1});
  for (nn::Index n = 0; n < count; ++n) {
    const FlowField& field = fields[static_cast<std::size_t>(n)];
    vo::FlowGrid::fill(field.correspondences, field.camera, n, sample.grids);
    const Eigen::Vector3d theta = field.T_left0_left1.rotation().log();
    const Eigen::Vector3d& p = field.T_left0_left1.translation();
    const bool moves = p.norm() > 0.0;
    const Eigen::Vector3d direction = moves ? p.normalized() : Eigen::Vector3d::UnitZ().eval();
    for (nn::Index i = 0; i < 3; ++i) {
      sample.truth.rotation[3 * n + i] = static_cast<float>(theta[i]);
      sample.truth.direction[3 * n + i] = static_cast<float>(direction[i]);
    }
    sample.truth.moves[n] = moves ? 1.0F : 0.0F;
  }
  return sample;
}

}  // namespace imslam::training
