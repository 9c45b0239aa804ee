#pragma once

#include <functional>
#include <string>
#include <vector>

namespace imslam::routing {

/// How much the gradients of the estimators scatter while a network is trained.
struct VarianceStudyOptions {
  int agents = 10;
  int cities = 50;
  int samples = 2;  ///< draws per instance, of every estimator
  int steps = 200;  ///< of the training, by the control variate
  int every = 20;   ///< steps between looks
  double surrogate_rate = 0.0003;
};

/// At one step: the variance of a mini-batch's gradient, over 16 mini-batches of 32 instances each,
/// summed over all weights of the network.
struct VarianceRow {
  int step = 0;
  double constant_baseline = 0.0;
  double sample_baseline = 0.0;
  double control_variate = 0.0;
};

/// Throws InputError(kUsage) on bad options.
std::vector<VarianceRow> variance_study(const VarianceStudyOptions& options,
                                        const std::function<void(int done, int steps)>& progress);

std::string variance_csv(const std::vector<VarianceRow>& rows);
std::string variance_svg(const VarianceStudyOptions& options, const std::vector<VarianceRow>& rows);

}  // namespace imslam::routing
