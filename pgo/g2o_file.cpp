#include "pgo/g2o_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <unordered_map>

#include "pgo/whitening.hpp"
#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"

namespace imslam::pgo {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Words = std::vector<std::string_view>;

/// [rho theta] = D [t vec(q)] near the identity.
Matrix6 rotation_vector_of(G2oTangent tangent) {
  const double factor = tangent == G2oTangent::kQuaternionVector ? 2.0 : 1.0;
  Eigen::Matrix<double, 6, 1> diagonal;
  diagonal << 1.0, 1.0, 1.0, factor, factor, factor;
  return diagonal.asDiagonal();
}

void append_pose(std::string& text, const lie::SE3d& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Vector4d q = pose.rotation().quaternion().coeffs();
  fmt::format_to(std::back_inserter(text), " {} {} {} {} {} {} {}", t.x(), t.y(), t.z(), q.x(),
                 q.y(), q.z(), q.w());
}

class Parser {
 public:
  Parser(const std::filesystem::path& file, G2oTangent tangent)
      : file_(file), D_(rotation_vector_of(tangent)) {}

  GraphData parse() {
    const std::string text = read_file(file_);
    for (std::string_view line : split(text, '\n')) {
      ++line_;
      if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
      const Words words = split_blanks(line);
      if (words.empty() || words[0].front() == '#') continue;
      if (words[0] == "VERTEX_SE3:QUAT") {
        parse_vertex(words);
      } else if (words[0] == "EDGE_SE3:QUAT") {
        parse_edge(words);
      } else if (words[0] != "FIX") {
        fail("expected VERTEX_SE3:QUAT or EDGE_SE3:QUAT; remove the line or convert the graph");
      }
    }
    return graph_;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", file_.string(), line_, what));
  }

  double number(const Words& words, std::size_t i) const {
    const auto value = parse_double(words[i]);
    if (!value || !std::isfinite(*value)) {
      fail(fmt::format("expected a finite number as word {}; correct it", i + 1));
    }
    return *value;
  }

  void parse_vertex(const Words& words) {
    if (words.size() != 9) fail("expected VERTEX_SE3:QUAT id x y z qx qy qz qw");
    const auto id = parse_int64(words[1]);
    if (!id) fail("expected a whole number as vertex id");
    const int index = static_cast<int>(graph_.states.size());
    if (!index_.emplace(*id, index).second) fail("vertex id occurs twice; remove one of them");
    State state;
    state.time_ns = index;
    state.nav.T_world_body = pose(words, 2);
    graph_.states.push_back(state);
  }

  void parse_edge(const Words& words) {
    if (words.size() != 31) {
      fail("expected EDGE_SE3:QUAT from to x y z qx qy qz qw and 21 information entries");
    }
    VisualEdge edge;
    edge.from = vertex(words[1]);
    edge.to = vertex(words[2]);
    if (edge.from == edge.to) fail("an edge must join two different vertices");
    edge.motion.T_body0_body1 = pose(words, 3);
    edge.motion.valid = true;
    Matrix6 information;
    std::size_t word = 10;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        information(row, column) = number(words, word++);
        information(column, row) = information(row, column);
      }
    }
    // e_rotation_vector = D e_file, so that the covariance is D Omega^-1 D.
    edge.motion.covariance = D_ * information.inverse() * D_;
    const auto W = sqrt_information(edge.motion.covariance);
    if (!W) fail("information matrix is not positive definite; correct it");
    edge.sqrt_information = *W;
    graph_.visual_edges.push_back(edge);
  }

  int vertex(std::string_view word) const {
    const auto id = parse_int64(word);
    const auto found = id ? index_.find(*id) : index_.end();
    if (found == index_.end()) fail("edge refers to a vertex that was not listed before it");
    return found->second;
  }

  lie::SE3d pose(const Words& words, std::size_t first) const {
    const Eigen::Vector3d t(number(words, first), number(words, first + 1),
                            number(words, first + 2));
    const Eigen::Quaterniond q(number(words, first + 6), number(words, first + 3),
                               number(words, first + 4), number(words, first + 5));
    if (std::abs(q.norm() - 1.0) > 1e-2) fail("expected a unit quaternion qx qy qz qw");
    return {lie::SO3d(q), t};
  }

  std::filesystem::path file_;
  Matrix6 D_;
  int line_ = 0;
  GraphData graph_;
  std::unordered_map<std::int64_t, int> index_;
};

}  // namespace

void write_g2o(const GraphData& graph, const std::filesystem::path& file) {
  std::string text;
  for (std::size_t i = 0; i < graph.states.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "VERTEX_SE3:QUAT {}", i);
    append_pose(text, graph.states[i].nav.T_world_body);
    text += '\n';
  }
  const Matrix6 D = rotation_vector_of(G2oTangent::kQuaternionVector);
  for (const VisualEdge& edge : graph.visual_edges) {
    fmt::format_to(std::back_inserter(text), "EDGE_SE3:QUAT {} {}", edge.from, edge.to);
    append_pose(text, edge.motion.T_body0_body1);
    const Matrix6 information = D * edge.sqrt_information.transpose() * edge.sqrt_information * D;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        fmt::format_to(std::back_inserter(text), " {}", information(row, column));
      }
    }
    text += '\n';
  }
  write_file_atomic(file, text);
}

GraphData read_g2o(const std::filesystem::path& file, G2oTangent tangent) {
  return Parser(file, tangent).parse();
}

}  // namespace imslam::pgo
