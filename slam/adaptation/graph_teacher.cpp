#include "slam/adaptation/graph_teacher.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/time.hpp"

namespace imslam::adaptation {
namespace {

constexpr double kVisualDimensions = 6.0;
constexpr double kInertialDimensions = 9.0;

double root_mean(const Eigen::Vector3d& variances) {
  return std::sqrt(std::max(0.0, variances.mean()));
}

}  // namespace

GraphTeacher::GraphTeacher(pgo::PoseVelocityGraph graph,
                           pgo::Posterior posterior,
                           bool joint,
                           std::optional<WholeGradient> whole,
                           std::optional<WholeGradient> loops,
                           double loop_weight)
    : graph_(std::move(graph)),
      posterior_(std::move(posterior)),
      joint_(joint),
      whole_(std::move(whole)),
      loops_(std::move(loops)),
      loop_weight_(loop_weight) {
  const auto& edges = graph_.visual_edges();
  for (std::size_t e = 0; e < edges.size(); ++e) {
    visual_edges_.insert({{edges[e].motion.time0_ns, edges[e].motion.time1_ns}, e});
  }
}

std::optional<GraphTeacher> GraphTeacher::of(const system::SlamResult& result,
                                             const AdaptationOptions& options,
                                             std::string& reason) {
  if (!result.solve.converged) {
    reason = "the graph has not converged: " + result.solve.reason;
    return std::nullopt;
  }
  pgo::PoseVelocityGraph graph(result.graph_options);
  graph.data() = result.graph_data;
  return of(std::move(graph), options, reason);
}

std::optional<GraphTeacher> GraphTeacher::of(pgo::PoseVelocityGraph graph,
                                             const AdaptationOptions& options,
                                             std::string& reason) {
  auto posterior = pgo::Posterior::of(graph);
  if (!posterior) {
    reason = "the graph does not determine its states";
    return std::nullopt;
  }
  std::optional<WholeGradient> whole;
  if (options.upper == "published") {
    whole = WholeGradient::of(graph, published_upper(options), options.strategy, reason);
    if (!whole) return std::nullopt;
  }
  std::optional<WholeGradient> loops;
  if (const auto upper = options.loop_weight > 0.0 ? loop_upper(graph, options) : std::nullopt) {
    loops = WholeGradient::of(graph, *upper, "implicit", reason);
    if (!loops) return std::nullopt;
  }
  return GraphTeacher(std::move(graph), std::move(*posterior), options.upper == "joint",
                      std::move(whole), std::move(loops), options.loop_weight);
}

std::optional<std::size_t> GraphTeacher::visual_edge(std::int64_t time0_ns,
                                                     std::int64_t time1_ns) const {
  const auto found = visual_edges_.find({time0_ns, time1_ns});
  if (found == visual_edges_.end()) return std::nullopt;
  return found->second;
}

vo::MotionCost GraphTeacher::cost_of(std::size_t visual_edge) const {
  const vo::MotionCost own = own_cost_of(visual_edge);
  if (!loops_) return own;
  return [this, own, visual_edge](const RelativeMotion& motion) {
    vo::MotionSlope sum = own(motion);
    const vo::MotionSlope loops = loops_->visual(visual_edge);
    sum.cost += loop_weight_ * loops.cost;
    sum.by_motion += loop_weight_ * loops.by_motion;
    sum.by_covariance += loop_weight_ * loops.by_covariance;
    return sum;
  };
}

vo::MotionCost GraphTeacher::own_cost_of(std::size_t visual_edge) const {
  if (whole_)
    return [this, visual_edge](const RelativeMotion&) { return whole_->visual(visual_edge); };
  pgo::Foretold<6> others;
  if (!joint_) others = pgo::foretold_visual(graph_, posterior_.residuals(), visual_edge);
  return [this, visual_edge, others](const RelativeMotion& motion) {
    const auto l = pgo::visual_likelihood(graph_, visual_edge, motion, others);
    return vo::MotionSlope{l.nll, l.gradient.motion, l.gradient.covariance};
  };
}

pgo::EdgeLikelihood<9> GraphTeacher::inertial(std::size_t edge, const ImuMotion& motion) const {
  pgo::EdgeLikelihood<9> sum = own_inertial(edge, motion);
  if (!loops_) return sum;
  const pgo::EdgeLikelihood<9> loops = loops_->inertial(edge);
  sum.nll += loop_weight_ * loops.nll;
  sum.gradient.motion += loop_weight_ * loops.gradient.motion;
  sum.gradient.covariance += loop_weight_ * loops.gradient.covariance;
  return sum;
}

pgo::EdgeLikelihood<9> GraphTeacher::own_inertial(std::size_t edge, const ImuMotion& motion) const {
  if (whole_) return whole_->inertial(edge);
  pgo::Foretold<9> others;
  if (!joint_) others = pgo::foretold_inertial(graph_, posterior_.residuals(), edge);
  return pgo::inertial_likelihood(graph_, edge, motion, others);
}

lie::SE3d GraphTeacher::T_body0_body1(std::size_t visual_edge) const {
  const pgo::VisualEdge& edge = graph_.visual_edges()[visual_edge];
  const auto& states = graph_.states();
  return states[static_cast<std::size_t>(edge.from)].nav.T_world_body.inverse() *
         states[static_cast<std::size_t>(edge.to)].nav.T_world_body;
}

double GraphTeacher::left_out_loss(const std::function<bool(std::size_t state)>& counts) const {
  double sum = 0.0;
  double dimensions = 0.0;
  const auto& visual = graph_.visual_edges();
  for (std::size_t e = 0; e < visual.size(); ++e) {
    if (!counts(static_cast<std::size_t>(visual[e].to))) continue;
    const auto others = pgo::foretold_visual(graph_, posterior_.residuals(), e);
    sum += pgo::visual_likelihood(graph_, e, visual[e].motion, others).nll;
    dimensions += kVisualDimensions;
  }
  const auto& inertial = graph_.inertial_edges();
  for (std::size_t e = 0; e < inertial.size(); ++e) {
    if (!counts(static_cast<std::size_t>(inertial[e].to))) continue;
    const auto others = pgo::foretold_inertial(graph_, posterior_.residuals(), e);
    sum += pgo::inertial_likelihood(graph_, e, inertial[e].motion, others).nll;
    dimensions += kInertialDimensions;
  }
  return dimensions > 0.0 ? sum / dimensions : 0.0;
}

training::InertialLog GraphTeacher::inertial_log(const std::vector<ImuSample>& samples,
                                                 const ImuNoise& noise) const {
  training::InertialLog log;
  log.name = "graph";
  log.samples = samples;
  log.noise = noise;
  const pgo::Globals& globals = graph_.globals();
  log.gravity_world = graph_.options().gravity_magnitude * globals.gravity_direction;
  const std::int64_t offset_ns = to_nanoseconds(globals.time_offset_s);
  const std::int64_t first_ns = samples.empty() ? 0 : samples.front().time_ns;
  const std::int64_t last_ns = samples.empty() ? 0 : samples.back().time_ns;
  for (const pgo::State& state : graph_.states()) {
    const std::int64_t time_ns = state.time_ns + offset_ns;
    if (time_ns >= first_ns && time_ns <= last_ns) log.truth.push_back({time_ns, state.nav});
  }
  // Of neighbours' differences: what they have in common does not spoil a window.
  const auto middle = static_cast<int>(graph_.states().size() / 2);
  const Eigen::Matrix<double, 18, 18> P = posterior_.joint(std::max(0, middle - 1), middle);
  const Eigen::Matrix<double, 9, 9> apart = P.topLeftCorner<9, 9>() + P.bottomRightCorner<9, 9>() -
                                            P.topRightCorner<9, 9>() - P.bottomLeftCorner<9, 9>();
  const Eigen::Matrix<double, 9, 1> of_one = 0.5 * apart.diagonal();
  log.truth_sigma.position = root_mean(of_one.head<3>());
  log.truth_sigma.rotation = root_mean(of_one.segment<3>(3));
  log.truth_sigma.velocity = root_mean(P.diagonal().segment<3>(6));
  log.truth_sigma.tilt = root_mean(P.diagonal().segment<3>(3));
  return log;
}

}  // namespace imslam::adaptation
