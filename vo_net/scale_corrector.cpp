#include "vo_net/scale_corrector.hpp"

#include <algorithm>
#include <cmath>

#include "vo_net/options_check.hpp"
#include "vo_net/scale_score.hpp"

namespace imslam::vo {
namespace {

using namespace detail;

constexpr double kMedianChiSquared2 = 1.386294361119891;  // 2 ln 2

/// The points that count, ready for evaluation.
class ScaleProblem {
 public:
  ScaleProblem(const Correspondences& correspondences,
               const StereoCamera& camera,
               const MotionDirection& motion,
               double disparity_offset)
      : view{camera, motion.R_left0_left1.inverse().matrix(), 1.0} {
    for (std::size_t k = 0; k < correspondences.size(); ++k) {
      const Correspondence& c = correspondences[k];
      const double disparity = c.disparity0 - disparity_offset;
      if (!usable(c, disparity)) continue;
      index.push_back(k);
      inputs.push_back({0.0, 0.0, 0.0, 0.0, motion.direction.x(), motion.direction.y(),
                        motion.direction.z(), c.left0.x(), c.left0.y(), c.left1.x(), c.left1.y(),
                        disparity, c.flow_information(0, 0),
                        0.5 * (c.flow_information(0, 1) + c.flow_information(1, 0)),
                        c.flow_information(1, 1), c.disparity0_information, c.weight});
    }
  }

  void set_scale(double s) {
    for (ScaleInputs<double>& x : inputs) x[kScale] = s;
  }

  /// dF/d(one input) of point `k`.
  double derivative(std::size_t k, std::size_t input) const {
    ScaleInputs<nn::Dual<double>> x;
    for (std::size_t i = 0; i < kScaleInputs; ++i) x[i] = nn::Dual<double>(inputs[k][i]);
    x[input].tangent = 1.0;
    return scale_score(view, x).tangent;
  }

  double derivative(std::size_t input) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < inputs.size(); ++k) sum += derivative(k, input);
    return sum;
  }

  ScaleView view;
  std::vector<ScaleInputs<double>> inputs;
  std::vector<std::size_t> index;  ///< of the correspondence

 private:
  static bool usable(const Correspondence& c, double disparity) {
    return c.left0.allFinite() && c.left1.allFinite() && std::isfinite(disparity) &&
           disparity > 0.0 && c.flow_information.allFinite() &&
           c.flow_information.determinant() > 0.0 && c.flow_information(0, 0) > 0.0 &&
           std::isfinite(c.disparity0_information) && c.disparity0_information > 0.0 &&
           std::isfinite(c.weight) && c.weight > 0.0;
  }
};

/// Where the weights on either side are equal.
double weighted_median(std::vector<std::pair<double, double>> value_and_weight) {
  std::sort(value_and_weight.begin(), value_and_weight.end());
  double half = 0.0;
  for (const auto& [value, weight] : value_and_weight) half += 0.5 * weight;
  for (const auto& [value, weight] : value_and_weight) {
    half -= weight;
    if (half <= 0.0) return value;
  }
  return 0.0;
}

/// Least absolute deviations of the published corrector's rows, divided by the depth without
/// translation: they are linear in s, so each point alone says an s.
double start_scale(const ScaleProblem& problem) {
  std::vector<std::pair<double, double>> alone;
  const StereoCamera& c = problem.view.camera;
  for (const ScaleInputs<double>& x : problem.inputs) {
    const Eigen::Vector3d B =
        problem.view.R_left1_left0 *
        Eigen::Vector3d((x[kLeft0U] - c.cx) / c.fx, (x[kLeft0V] - c.cy) / c.fy, 1.0);
    if (!(B.z() > 0.05)) continue;
    const Eigen::Vector3d a = problem.view.R_left1_left0 *
                              Eigen::Vector3d(x[kDirectionX], x[kDirectionY], x[kDirectionZ]) *
                              (-x[kDisparity] / (c.fx * c.baseline_m));
    const Eigen::Vector2d q((x[kLeft1U] - c.cx) / c.fx, (x[kLeft1V] - c.cy) / c.fy);
    const Eigen::Vector2d M = (a.z() * q - a.head<2>()) / B.z();
    const Eigen::Vector2d w = (B.head<2>() - B.z() * q) / B.z();
    const double information = M.squaredNorm();
    if (information > 0.0) {
      alone.emplace_back(M.dot(w) / information, x[kWeight] * std::sqrt(information));
    }
  }
  return weighted_median(std::move(alone));
}

double median_square(const ScaleProblem& problem) {
  std::vector<double> squares;
  for (const ScaleInputs<double>& x : problem.inputs) {
    const ScalePoint<double> p = evaluate_scale_point(problem.view, x);
    if (p.in_front) squares.push_back(p.square);
  }
  if (squares.empty()) return 0.0;
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  return *middle;
}

/// F(s) and the slope that a round of reweighting takes it to have.
struct Sums {
  double score = 0.0;
  double information = 0.0;  ///< [1/m^2]
};

Sums sums_of(const ScaleProblem& problem) {
  Sums sums;
  for (const ScaleInputs<double>& x : problem.inputs) {
    const ScalePoint<double> p = evaluate_scale_point(problem.view, x);
    if (!p.in_front) continue;
    const double w = x[kWeight] * huber_slope(p.square, problem.view.kernel_square);
    sums.score += w * (p.weighted_slope[0] * p.e[0] + p.weighted_slope[1] * p.e[1]);
    sums.information += w * (p.weighted_slope[0] * p.slope[0] + p.weighted_slope[1] * p.slope[1]);
  }
  return sums;
}

void mark_inliers(const ScaleProblem& problem, const ScaleOptions& options, ScaleResult& result) {
  const double bound = options.inlier_threshold * result.noise_scale;
  for (std::size_t k = 0; k < problem.inputs.size(); ++k) {
    const ScalePoint<double> p = evaluate_scale_point(problem.view, problem.inputs[k]);
    if (!p.in_front || !(p.square <= bound * bound)) continue;
    result.is_inlier[problem.index[k]] = 1;
    ++result.inliers;
  }
}

ScaleState judge(const ScaleResult& result, const ScaleOptions& options) {
  if (result.scale < -options.backwards * result.sigma) return ScaleState::kBackwards;
  if (result.scale < options.standing_still * result.sigma) return ScaleState::kStandingStill;
  return ScaleState::kMoving;
}

void differentiate(const ScaleProblem& problem, ScaleResult& result) {
  const double by_scale = problem.derivative(kScale);
  if (!(by_scale > 0.0)) return;
  for (int i = 0; i < 3; ++i) {
    const auto n = static_cast<std::size_t>(i);
    result.J_rotation[i] = -problem.derivative(kTurnX + n) / by_scale;
    result.J_direction[i] = -problem.derivative(kDirectionX + n) / by_scale;
  }
  result.J_disparity_offset = problem.derivative(kDisparity) / by_scale;
}

ScalePointGradient point_gradient(const ScaleProblem& problem, std::size_t k, double by_scale) {
  const auto of = [&](std::size_t input) { return -problem.derivative(k, input) / by_scale; };
  ScalePointGradient g;
  g.left0 = {of(kLeft0U), of(kLeft0V)};
  g.left1 = {of(kLeft1U), of(kLeft1V)};
  g.disparity0 = of(kDisparity);
  const double off_diagonal = 0.5 * of(kInformationUV);  // each of the two entries
  g.flow_information << of(kInformationUU), off_diagonal, off_diagonal, of(kInformationVV);
  g.disparity0_information = of(kDisparityInformation);
  g.weight = of(kWeight);
  return g;
}

void set_noise_scale(ScaleProblem& problem, const ScaleOptions& options, double noise_scale) {
  const double bend = options.kernel_width * noise_scale;
  problem.view.kernel_square = bend * bend;
}

}  // namespace

void ScaleOptions::describe(Config& config) {
  config.field("kernel_width", kernel_width, "where Huber's kernel bends [standard deviations]");
  config.field("adapt_noise_scale", adapt_noise_scale, "estimate how far off informations are");
  config.field("min_noise_scale", min_noise_scale, "true over stated standard deviation [1]");
  config.field("max_noise_scale", max_noise_scale, "likewise; beyond it the motion does not fit");
  config.field("max_rounds", max_rounds, "of reweighting");
  config.field("tolerance", tolerance, "last change [standard deviations of the scale]");
  config.field("inlier_threshold", inlier_threshold, "[standard deviations]");
  config.field("standing_still", standing_still, "shorter is no motion [standard deviations]");
  config.field("backwards", backwards, "further against the direction is a contradiction [same]");
}

void ScaleOptions::validate() const {
  require(kernel_width > 0.0, "vo.regression.scale.kernel_width", kernel_width, "> 0");
  require(min_noise_scale > 0.0, "vo.regression.scale.min_noise_scale", min_noise_scale, "> 0");
  require(max_noise_scale >= min_noise_scale, "vo.regression.scale.max_noise_scale",
          max_noise_scale, ">= min_noise_scale");
  require(max_rounds >= 1 && max_rounds <= 1000, "vo.regression.scale.max_rounds", max_rounds,
          "1 .. 1000");
  require(tolerance > 0.0, "vo.regression.scale.tolerance", tolerance, "> 0");
  require(inlier_threshold > 0.0, "vo.regression.scale.inlier_threshold", inlier_threshold, "> 0");
  require(standing_still >= 0.0, "vo.regression.scale.standing_still", standing_still, ">= 0");
  require(backwards >= 0.0, "vo.regression.scale.backwards", backwards, ">= 0");
}

ScaleResult correct_scale(const Correspondences& correspondences,
                          const StereoCamera& camera,
                          const MotionDirection& motion,
                          const ScaleOptions& options,
                          double disparity_offset) {
  ScaleResult result;
  result.is_inlier.assign(correspondences.size(), 0);
  ScaleProblem problem(correspondences, camera, motion, disparity_offset);
  if (problem.inputs.empty()) return result;
  double s = start_scale(problem);
  problem.set_scale(s);
  if (options.adapt_noise_scale) {
    result.noise_scale = std::clamp(std::sqrt(median_square(problem) / kMedianChiSquared2),
                                    options.min_noise_scale, options.max_noise_scale);
  }
  set_noise_scale(problem, options, result.noise_scale);
  Sums sums = sums_of(problem);
  while (result.rounds < options.max_rounds && sums.information > 0.0 && !result.converged) {
    const double step = -sums.score / sums.information;
    s += step;
    problem.set_scale(s);
    sums = sums_of(problem);
    result.converged =
        std::abs(step) * std::sqrt(sums.information) < options.tolerance * result.noise_scale;
    ++result.rounds;
  }
  if (!(sums.information > 0.0) || !std::isfinite(s) || !std::isfinite(sums.information)) {
    return result;
  }
  result.scale = s;
  result.sigma = result.noise_scale / std::sqrt(sums.information);
  mark_inliers(problem, options, result);
  result.state = judge(result, options);
  if (result.state == ScaleState::kStandingStill) {
    result.sigma = std::hypot(result.sigma, s);
    result.scale = 0.0;
    return result;
  }
  differentiate(problem, result);
  return result;
}

std::optional<std::vector<ScalePointGradient>> scale_gradient(
    const Correspondences& correspondences,
    const StereoCamera& camera,
    const MotionDirection& motion,
    const ScaleOptions& options,
    const ScaleResult& result,
    double disparity_offset) {
  const bool moves = result.state == ScaleState::kMoving || result.state == ScaleState::kBackwards;
  if (!moves || !result.converged) return std::nullopt;
  ScaleProblem problem(correspondences, camera, motion, disparity_offset);
  problem.set_scale(result.scale);
  set_noise_scale(problem, options, result.noise_scale);
  const double by_scale = problem.derivative(kScale);
  if (!(by_scale > 0.0)) return std::nullopt;
  std::vector<ScalePointGradient> gradients(correspondences.size());
  for (std::size_t k = 0; k < problem.inputs.size(); ++k) {
    gradients[problem.index[k]] = point_gradient(problem, k, by_scale);
  }
  return gradients;
}

}  // namespace imslam::vo
