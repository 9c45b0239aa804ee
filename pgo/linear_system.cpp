#include "pgo/linear_system.hpp"

namespace imslam::pgo {

std::vector<BlockId> estimated_blocks(GraphProblem& graph, int states) {
  using Kind = BlockId::Kind;
  std::vector<BlockId> blocks;
  const auto add = [&](Kind kind, int state) {
    const BlockId id{kind, state};
    if (graph.estimated(id)) blocks.push_back(id);
  };
  for (int i = 0; i < states; ++i) {
    for (Kind kind : {Kind::kPose, Kind::kVelocity, Kind::kBias}) add(kind, i);
  }
  for (Kind kind : {Kind::kGravity, Kind::kDisparityOffset, Kind::kFocalError, Kind::kTimeOffset,
                    Kind::kCameraRotation, Kind::kGyroShape}) {
    add(kind, 0);
  }
  return blocks;
}

LinearSystem linearize(GraphProblem& graph,
                       const std::vector<BlockId>& blocks,
                       const std::vector<ceres::ResidualBlockId>& residuals) {
  LinearSystem system;
  system.blocks = blocks;
  system.offsets.push_back(0);
  ceres::Problem::EvaluateOptions options;
  options.residual_blocks = residuals;
  for (const BlockId& id : blocks) {
    options.parameter_blocks.push_back(graph.block(id));
    system.offsets.push_back(system.offsets.back() + tangent_size(id.kind));
  }
  ceres::CRSMatrix crs;
  std::vector<double> values;
  graph.problem().Evaluate(options, nullptr, &values, nullptr, &crs);
  system.residual =
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  system.J = Eigen::Map<const RowMajor>(crs.num_rows, crs.num_cols,
                                        static_cast<Eigen::Index>(crs.values.size()),
                                        crs.rows.data(), crs.cols.data(), crs.values.data());
  return system;
}

}  // namespace imslam::pgo
