#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "pgo/linear_system.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "pgo/selected_inverse.hpp"

namespace imslam::pgo {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Where the unknowns of one state stand: column of the system, row in [rho theta nu gyro accel].
struct Place {
  Eigen::Index column;
  Eigen::Index row;
};

Eigen::Index first_row(BlockId::Kind kind) {
  if (kind == BlockId::Kind::kPose) return 0;
  return kind == BlockId::Kind::kVelocity ? 6 : 9;
}

std::vector<std::vector<Place>> places_of_states(const LinearSystem& system, std::size_t states) {
  std::vector<std::vector<Place>> places(states);
  for (std::size_t b = 0; b < system.blocks.size(); ++b) {
    const BlockId& id = system.blocks[b];
    if (id.global()) continue;
    for (Eigen::Index d = 0; d < system.offsets[b + 1] - system.offsets[b]; ++d) {
      places[static_cast<std::size_t>(id.state)].push_back(
          {system.offsets[b] + d, first_row(id.kind) + d});
    }
  }
  return places;
}

/// J^T J with an entry, if only a zero one, for every pair of unknowns of the same state.
Eigen::SparseMatrix<double> information(const LinearSystem& system,
                                        const std::vector<std::vector<Place>>& places) {
  Triplets zeros;
  for (const auto& state : places) {
    for (const Place& a : state) {
      for (const Place& b : state) {
        zeros.emplace_back(static_cast<int>(a.column), static_cast<int>(b.column), 0.0);
      }
    }
  }
  Eigen::SparseMatrix<double> pattern(system.columns(), system.columns());
  pattern.setFromTriplets(zeros.begin(), zeros.end());
  const Eigen::SparseMatrix<double> H = system.J.transpose() * system.J;
  return H + pattern;
}

GlobalSigmas sigmas_of_globals(const LinearSystem& system, const SelectedInverse& inverse) {
  GlobalSigmas sigmas;
  for (std::size_t b = 0; b < system.blocks.size(); ++b) {
    const Eigen::Index column = system.offsets[b];
    const auto sigma_at = [&](Eigen::Index i) {
      return std::sqrt(std::max(0.0, inverse(column + i, column + i)));
    };
    switch (system.blocks[b].kind) {
      case BlockId::Kind::kDisparityOffset:
        sigmas.disparity_offset = sigma_at(0);
        break;
      case BlockId::Kind::kFocalError:
        sigmas.focal_error = sigma_at(0);
        break;
      case BlockId::Kind::kTimeOffset:
        sigmas.time_offset_s = sigma_at(0);
        break;
      case BlockId::Kind::kCameraRotation:
        sigmas.camera_rotation.emplace(sigma_at(0), sigma_at(1), sigma_at(2));
        break;
      case BlockId::Kind::kGyroShape:
        sigmas.gyro_shape.emplace();
        for (Eigen::Index i = 0; i < 9; ++i) (*sigmas.gyro_shape)(i / 3, i % 3) = sigma_at(i);
        break;
      default:
        break;
    }
  }
  return sigmas;
}

}  // namespace

std::optional<GraphUncertainty> PoseVelocityGraph::uncertainty() const {
  if (!unsolvable_reason(data_).empty()) return std::nullopt;
  GraphProblem graph(data_, options_);
  const LinearSystem system =
      linearize(graph, estimated_blocks(graph, static_cast<int>(data_.states.size())));
  const auto places = places_of_states(system, data_.states.size());
  const auto inverse = SelectedInverse::factorize(information(system, places));
  if (!inverse) return std::nullopt;

  GraphUncertainty result;
  result.globals = sigmas_of_globals(system, *inverse);
  result.states.assign(data_.states.size(), StateCovariance::Zero());
  for (std::size_t i = 0; i < result.states.size(); ++i) {
    for (const Place& a : places[i]) {
      for (const Place& b : places[i]) {
        result.states[i](a.row, b.row) = (*inverse)(a.column, b.column);
      }
    }
  }
  return result;
}

std::optional<std::vector<StateCovariance>> PoseVelocityGraph::covariances() const {
  auto all = uncertainty();
  if (!all) return std::nullopt;
  return std::move(all->states);
}

std::optional<StateCovariance> PoseVelocityGraph::covariance(int state) const {
  expect_state(state);
  const auto all = covariances();
  if (!all) return std::nullopt;
  return (*all)[static_cast<std::size_t>(state)];
}

}  // namespace imslam::pgo
