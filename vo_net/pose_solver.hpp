#pragma once

#include <cmath>
#include <optional>
#include <utility>

#include "vo_net/pose_layer_system.hpp"

namespace imslam::vo::detail {

/// One descent to the most likely motion, see solve_pose().
class Solver {
 public:
  /// `agreeing`: the share of the points that the start is known to fit to; 1: nothing is known.
  Solver(Problem problem, const PoseLayerOptions& options, Estimate start, double agreeing)
      : problem_(std::move(problem)),
        options_(options),
        estimate_(std::move(start)),
        agreeing_(agreeing) {}

  bool solve() { return start() && refine(); }
  /// Share of the usable points with s below `limit`.
  double share_below(double limit);
  const Problem& problem() const { return problem_; }
  const Estimate& estimate() const { return estimate_; }
  double noise_scale() const { return noise_scale_; }
  bool converged() const { return converged_; }
  int iterations() const { return iterations_; }

 private:
  /// Follows the minimum while the kernel narrows with the median residual.
  bool start();
  /// Levenberg-Marquardt at a fixed kernel; again with a narrower one if the start stopped too
  /// soon. False if the points do not agree on a motion.
  bool refine();
  void descend();
  double measured_noise_scale(const ReducedSystem& system) const;
  void set_kernel(double scale) { problem_.kernel_k2 = std::pow(options_.kernel_width * scale, 2); }
  std::optional<Estimate> moved(const ReducedSystem& system, double* decrement);
  Model model_after(double decrement) const {
    return decrement < 1.0 ? Model::kExact : Model::kGaussNewton;
  }

  Problem problem_;
  const PoseLayerOptions& options_;
  Estimate estimate_;
  double agreeing_;
  ReducedSystem system_;
  ReducedSystem candidate_system_;
  double noise_scale_ = 1.0;
  bool converged_ = false;
  int iterations_ = 0;
};

}  // namespace imslam::vo::detail
