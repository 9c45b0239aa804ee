#include "slam/adaptation/visual_lesson.hpp"

#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "vo_net/match_labels.hpp"
#include "vo_net/pose_head_loss.hpp"
#include "vo_net/regression_cost.hpp"

namespace imslam::adaptation {
namespace {

using nn::Var;

constexpr double kDimensions = 6.0;
constexpr double kEarlyLook = 0.3;        // weight of looks before the last, see pose_head_loss()
constexpr double kLeastMotion_m = 0.002;  // shorter ones have no direction

Var noise_of(nn::Tape<float>& tape, const MotionTrace& trace, const LearnedNetworks& networks) {
  if (networks.motion_noise() == nullptr) return {};
  const Var features =
      tape.constant({1, vo::MotionNoiseFeatures::kCount}, trace.features.values.data());
  return networks.motion_noise()->forward(tape, features);
}

vo::MotionRecipe recipe_of(const MotionTrace& trace, const VisualClass& of) {
  vo::MotionRecipe recipe;
  recipe.camera = of.camera;
  recipe.pose = of.vo.pose;
  recipe.sigma_floor = of.vo.learned.sigma_floor;
  recipe.shared_error = of.vo.shared_error;
  recipe.start = trace.pose.T_body0_body1;
  recipe.disparity_offset = trace.pose.disparity_offset;
  recipe.time0_ns = trace.before->time_ns;
  recipe.time1_ns = trace.now->time_ns;
  return recipe;
}

Var match_lesson(nn::Tape<float>& tape,
                 const vo::ReplayedMatch& match,
                 const MotionTrace& trace,
                 const VisualClass& of,
                 std::size_t edge) {
  const vo::MatchLabels labels =
      vo::match_labels(trace.correspondences, trace.pose, of.camera, of.teacher.T_body0_body1(edge),
                       of.teacher.disparity_offset(), match.shrink);
  const Var flow = vo::match_loss(tape, match.flow, labels.flow).total;
  const Var stereo = add(tape, vo::match_loss(tape, match.stereo0, labels.stereo0).total,
                         vo::match_loss(tape, match.stereo1, labels.stereo1).total);
  return add(tape, flow, stereo);
}

/// Matching network, pose layer, graph.
Var matcher_lesson(nn::Tape<float>& tape,
                   const MotionTrace& trace,
                   const VisualClass& of,
                   std::size_t edge,
                   bool& usable) {
  const vo::ReplayImages images{&trace.before->left, &trace.before->right, &trace.now->left,
                                &trace.now->right, trace.search};
  const vo::ReplayedMatch match =
      vo::replay_match(tape, *of.networks.match(), images, trace.correspondences);
  const auto motion = vo::motion_cost(tape, match, trace.correspondences, recipe_of(trace, of),
                                      noise_of(tape, trace, of.networks), of.teacher.cost_of(edge));
  usable = motion.usable;
  Var total = scale(tape, motion.cost, of.options.graph_weight / kDimensions);
  if (of.options.match_weight > 0.0) {
    total = add(tape, total,
                scale(tape, match_lesson(tape, match, trace, of, edge), of.options.match_weight));
  }
  return total;
}

/// The graph's motion as the pose head should have said it.
vo::PoseHeadTruth<float> head_truth(const lie::SE3d& T_body0_body1, const StereoCamera& camera) {
  const lie::SE3d T_left0_left1 = camera.T_body_left.inverse() * T_body0_body1 * camera.T_body_left;
  const Eigen::Vector3d theta = T_left0_left1.rotation().log();
  const Eigen::Vector3d& p = T_left0_left1.translation();
  const bool moves = p.norm() > kLeastMotion_m;
  const Eigen::Vector3d direction = moves ? p.normalized() : Eigen::Vector3d::UnitZ().eval();
  vo::PoseHeadTruth<float> truth{nn::Tensor<float>({1, 3}), nn::Tensor<float>({1, 3}),
                                 nn::Tensor<float>({1, 1})};
  for (nn::Index i = 0; i < 3; ++i) {
    truth.rotation[i] = static_cast<float>(theta[i]);
    truth.direction[i] = static_cast<float>(direction[i]);
  }
  truth.moves[0] = moves ? 1.0F : 0.0F;
  return truth;
}

/// Of a motion before the network for the noise has a say; see VisualOdometry.
Eigen::Matrix<double, 6, 6> bare_covariance(const MotionTrace& trace, const VisualClass& of) {
  const double shared = of.vo.head == "geometric" ? of.vo.shared_error : 0.0;
  return trace.pose.covariance * (1.0 + shared * static_cast<double>(trace.pose.inliers));
}

/// Matches that do not learn, pose head, scale, graph.
Var head_lesson(nn::Tape<float>& tape,
                const MotionTrace& trace,
                const VisualClass& of,
                std::size_t edge,
                bool& usable) {
  const auto motion = vo::regression_cost(
      tape, *of.networks.pose_head(), trace.correspondences, recipe_of(trace, of),
      of.vo.regression.scale, noise_of(tape, trace, of.networks), of.teacher.cost_of(edge));
  usable = motion.usable;
  const Var said = vo::pose_head_loss(
      tape, motion.looks, head_truth(of.teacher.T_body0_body1(edge), of.camera), kEarlyLook);
  return add(tape, scale(tape, motion.cost, of.options.graph_weight / kDimensions),
             scale(tape, said, of.options.match_weight));
}

}  // namespace

Var visual_lesson(nn::Tape<float>& tape,
                  const MotionTrace& trace,
                  const VisualClass& of,
                  bool& usable) {
  usable = false;
  const auto edge = of.teacher.visual_edge(trace.before->time_ns, trace.now->time_ns);
  const Var nothing = tape.constant(nn::Tensor<float>({1}));
  if (!edge) return nothing;
  const bool geometric = of.vo.head == "geometric";
  if (!geometric && of.networks.pose_head() != nullptr) {
    return head_lesson(tape, trace, of, *edge, usable);
  }
  if (geometric && of.networks.match() != nullptr) {
    return matcher_lesson(tape, trace, of, *edge, usable);
  }
  const Var noise = noise_of(tape, trace, of.networks);
  if (!noise) return nothing;
  usable = true;
  RelativeMotion motion = of.teacher.graph().visual_edges()[*edge].motion;
  motion.covariance = bare_covariance(trace, of);  // the graph's has the factors of now in it
  return scale(tape, noise_cost(tape, motion, noise, of.teacher.cost_of(*edge)),
               of.options.graph_weight / kDimensions);
}

}  // namespace imslam::adaptation
