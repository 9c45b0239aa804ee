#pragma once

#include <filesystem>

#include "pgo/graph_data.hpp"

namespace imslam::pgo {

/// In which tangent the information matrices of a g2o file are meant. Files do not say.
///
///   kQuaternionVector   [t, vec(q)]     what the g2o program itself means: half the angle
///   kRotationVector     [t, 2 vec(q)]   what Ceres' and GTSAM's readers take it for
enum class G2oTangent { kQuaternionVector, kRotationVector };

/// Writes the poses and visual edges: VERTEX_SE3:QUAT and EDGE_SE3:QUAT, poses as translation and
/// quaternion x y z w, information in g2o's own tangent (kQuaternionVector), upper triangle by
/// rows. Inertial edges, priors, velocities and biases have no place in the format.
/// Throws InputError(kOutput) if the file cannot be written.
void write_g2o(const GraphData& graph, const std::filesystem::path& file);

/// Reads vertices as states (in order of appearance, stamped 0, 1, ... ns) and edges as visual
/// edges. Lines of other kinds are errors. The first vertex is not anchored.
/// Throws InputError "file:line: ..." on anything malformed.
GraphData read_g2o(const std::filesystem::path& file,
                   G2oTangent tangent = G2oTangent::kQuaternionVector);

}  // namespace imslam::pgo
