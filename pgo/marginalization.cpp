#include "pgo/marginalization.hpp"

#include <Eigen/QR>
#include <algorithm>

#include "pgo/linear_system.hpp"
#include "slam/base/error.hpp"

namespace imslam::pgo {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The part of the graph that the first state takes with it: its factors, and those on the globals
/// alone stay. Bias walks follow from the stamps: only that of the first interval is wanted.
GraphData factors_of_first_state(const GraphData& data) {
  GraphData part;
  part.states = data.states;
  part.globals = data.globals;
  part.T_body_left = data.T_body_left;
  part.marginal = data.marginal;
  const auto copy_touching = [](const auto& from, auto& to, const auto& touches) {
    std::copy_if(from.begin(), from.end(), std::back_inserter(to), touches);
  };
  const auto edge = [](const auto& e) { return e.from == 0 || e.to == 0; };
  const auto prior = [](const auto& p) { return p.state == 0; };
  copy_touching(data.visual_edges, part.visual_edges, edge);
  copy_touching(data.inertial_edges, part.inertial_edges, edge);
  copy_touching(data.pose_priors, part.pose_priors, prior);
  copy_touching(data.anchors, part.anchors, prior);
  copy_touching(data.velocity_priors, part.velocity_priors, prior);
  copy_touching(data.bias_priors, part.bias_priors, prior);
  return part;
}

void move_to_first_estimates(GraphData& data) {
  const MarginalPrior& prior = data.marginal;
  for (std::size_t b = 0; b < prior.blocks.size(); ++b) {
    const BlockId& id = prior.blocks[b];
    const VectorXd& X = prior.point[b];
    State* state = id.global() ? nullptr : &data.states[static_cast<std::size_t>(id.state)];
    switch (id.kind) {
      case BlockId::Kind::kPose:
        state->nav.T_world_body = pose_from_block(X.data());
        break;
      case BlockId::Kind::kVelocity:
        state->nav.v_world = X;
        break;
      case BlockId::Kind::kBias:
        state->bias = {X.head<3>(), X.tail<3>()};
        break;
      case BlockId::Kind::kGravity:
        data.globals.gravity_direction = X;
        break;
      case BlockId::Kind::kDisparityOffset:
        data.globals.disparity_offset = X(0);
        break;
      case BlockId::Kind::kFocalError:
        data.globals.focal_error = X(0);
        break;
      case BlockId::Kind::kTimeOffset:
        data.globals.time_offset_s = X(0);
        break;
      case BlockId::Kind::kCameraRotation:
        data.globals.camera_rotation = X;
        break;
      case BlockId::Kind::kGyroShape:
        data.globals.gyro_shape =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(X.data());
        break;
    }
  }
}

/// Rows of [A | B r] that do not depend on m any more, then as few of them as say the same.
void eliminate(const LinearSystem& system, Eigen::Index marginalized, MarginalPrior& prior) {
  const Eigen::Index kept = system.columns() - marginalized;
  MatrixXd rest(system.J.rows(), kept + 1);
  const MatrixXd J(system.J);
  rest << J.rightCols(kept), system.residual;
  if (marginalized > 0) {
    // Columns are scaled first: units are mixed, the rank must not depend on them.
    MatrixXd A = J.leftCols(marginalized);
    for (Eigen::Index c = 0; c < A.cols(); ++c) {
      const double norm = A.col(c).norm();
      if (norm > 0.0) A.col(c) /= norm;
    }
    Eigen::ColPivHouseholderQR<MatrixXd> qr(A);
    qr.setThreshold(1e-12);
    rest.applyOnTheLeft(qr.householderQ().transpose());
    rest = rest.bottomRows(rest.rows() - qr.rank()).eval();
  }
  if (rest.rows() > kept) {
    const Eigen::HouseholderQR<MatrixXd> qr(rest);
    const Eigen::Index rows = std::min(rest.rows(), kept + 1);
    rest = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
    rest.conservativeResize(std::min(rows, kept), Eigen::NoChange);  // the last row: a constant
  }
  prior.J = rest.leftCols(kept);
  prior.residual = rest.col(kept);
}

}  // namespace

MarginalPrior marginalize_first_state(const GraphData& data, const GraphOptions& options) {
  expects(data.states.size() >= 2, "marginalisation needs a state that remains");
  GraphData part = factors_of_first_state(data);
  move_to_first_estimates(part);
  GraphProblem graph(part, options, has_biases(data) ? BiasWalks::kFirst : BiasWalks::kNone);

  std::vector<BlockId> gone;
  std::vector<BlockId> kept;
  for (const BlockId& id : estimated_blocks(graph, static_cast<int>(part.states.size()))) {
    (!id.global() && id.state == 0 ? gone : kept).push_back(id);
  }
  std::vector<BlockId> all = gone;
  all.insert(all.end(), kept.begin(), kept.end());
  const LinearSystem system = linearize(graph, all);

  MarginalPrior prior;
  prior.blocks = kept;
  for (const BlockId& id : kept) {
    prior.point.emplace_back(Eigen::Map<const VectorXd>(graph.block(id), block_size(id.kind)));
  }
  eliminate(system, system.offsets[gone.size()], prior);
  return prior;
}

void drop_first_state(GraphData& data, MarginalPrior prior) {
  data.states.erase(data.states.begin());
  const auto shift_edges = [](auto& edges) {
    const auto touches = [](const auto& e) { return e.from == 0 || e.to == 0; };
    edges.erase(std::remove_if(edges.begin(), edges.end(), touches), edges.end());
    for (auto& e : edges) {
      --e.from;
      --e.to;
    }
  };
  const auto shift_priors = [](auto& priors) {
    const auto touches = [](const auto& p) { return p.state == 0; };
    priors.erase(std::remove_if(priors.begin(), priors.end(), touches), priors.end());
    for (auto& p : priors) --p.state;
  };
  shift_edges(data.visual_edges);
  shift_edges(data.inertial_edges);
  shift_priors(data.pose_priors);
  shift_priors(data.anchors);
  shift_priors(data.velocity_priors);
  shift_priors(data.bias_priors);
  for (BlockId& id : prior.blocks) {
    if (!id.global()) --id.state;
  }
  data.marginal = std::move(prior);
}

}  // namespace imslam::pgo
