#include "slam/plugins/routing/variance_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "slam/plugins/routing/routing_training.hpp"

namespace imslam::routing {
namespace {

constexpr int kMiniBatch = 32;
constexpr int kMiniBatches = 16;
constexpr double kWidth = 640.0;
constexpr double kHeight = 400.0;
constexpr double kMargin = 60.0;

struct Curve {
  const char* name;
  const char* colour;
  double VarianceRow::*value;
};
constexpr Curve kCurves[] = {
    {"log derivative, constant baseline", "#b33", &VarianceRow::constant_baseline},
    {"log derivative, S-sample baseline", "#36c", &VarianceRow::sample_baseline},
    {"control variate", "#282", &VarianceRow::control_variate}};

}  // namespace

std::vector<VarianceRow> variance_study(const VarianceStudyOptions& options,
                                        const std::function<void(int, int)>& progress) {
  RoutingTrainingOptions training_options;
  training_options.agents = options.agents;
  training_options.cities = options.cities;
  training_options.samples = options.samples;
  training_options.steps = options.steps;
  training_options.batch = kMiniBatch;
  training_options.surrogate_rate = options.surrogate_rate;
  training_options.warm_up = std::min(training_options.warm_up, options.steps);
  RoutingTraining training(training_options);
  std::vector<VarianceRow> rows;
  for (int step = 0; step <= options.steps; ++step) {
    if (step % options.every == 0) {
      rows.push_back({step, training.gradient_variance("constant_baseline", kMiniBatches),
                      training.gradient_variance("sample_baseline", kMiniBatches),
                      training.gradient_variance("control_variate", kMiniBatches)});
    }
    if (step < options.steps) training.step();
    progress(step, options.steps);
  }
  return rows;
}

std::string variance_csv(const std::vector<VarianceRow>& rows) {
  std::string text =
      "step,constant_baseline,sample_baseline,control_variate,ratio_constant,ratio_sample\n";
  for (const VarianceRow& row : rows) {
    text += fmt::format("{},{:.6g},{:.6g},{:.6g},{:.3g},{:.3g}\n", row.step, row.constant_baseline,
                        row.sample_baseline, row.control_variate,
                        row.constant_baseline / row.control_variate,
                        row.sample_baseline / row.control_variate);
  }
  return text;
}

std::string variance_svg(const VarianceStudyOptions& options,
                         const std::vector<VarianceRow>& rows) {
  double low = 1e300;
  double high = 1e-300;
  for (const VarianceRow& row : rows) {
    for (const Curve& curve : kCurves) {
      low = std::min(low, std::max(row.*curve.value, 1e-12));
      high = std::max(high, row.*curve.value);
    }
  }
  const double first = std::floor(std::log10(low));
  const double decades = std::max(1.0, std::ceil(std::log10(high)) - first);
  const auto x_of = [&](int step) {
    return kMargin + (kWidth - 2.0 * kMargin) * step / std::max(options.steps, 1);
  };
  const auto y_of = [&](double variance) {
    const double share = (std::log10(std::max(variance, 1e-12)) - first) / decades;
    return kHeight - kMargin - (kHeight - 2.0 * kMargin) * share;
  };
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" "
      "font-size=\"13\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n"
      "<text x=\"{2}\" y=\"22\">Variance of the gradient, {3} agents, {4} cities, {5} draws per "
      "instance</text>\n<text x=\"{6}\" y=\"{7}\">training steps (0 to {8})</text>\n",
      kWidth, kHeight, kMargin, options.agents, options.cities, options.samples,
      kWidth / 2.0 - 60.0, kHeight - 20.0, options.steps);
  for (int k = 0; k <= static_cast<int>(decades); ++k) {
    const double y = y_of(std::pow(10.0, first + k));
    svg += fmt::format(
        "<line x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#ccc\"/><text x=\"8\" "
        "y=\"{:.1f}\">1e{}</text>\n",
        kMargin, kWidth - kMargin, y, y, y + 4.0, static_cast<int>(first) + k);
  }
  double legend = 44.0;
  for (const Curve& curve : kCurves) {
    std::string line;
    for (const VarianceRow& row : rows) {
      line += fmt::format("{:.1f},{:.1f} ", x_of(row.step), y_of(row.*curve.value));
    }
    svg += fmt::format(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>"
        "<text x=\"{}\" y=\"{}\" fill=\"{}\">{}</text>\n",
        line, curve.colour, kWidth - 290.0, legend, curve.colour, curve.name);
    legend += 16.0;
  }
  return svg + "</svg>\n";
}

}  // namespace imslam::routing
