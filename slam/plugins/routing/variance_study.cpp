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

/// Steps to the right, the logarithm of the variance upwards in whole decades.
class Chart {
 public:
  Chart(const VarianceStudyOptions& options, const std::vector<VarianceRow>& rows)
      : steps_(std::max(options.steps, 1)) {
    double low = 1e300;
    double high = kLeast;
    for (const VarianceRow& row : rows) {
      for (const Curve& curve : kCurves) {
        low = std::min(low, std::max(row.*curve.value, kLeast));
        high = std::max(high, row.*curve.value);
      }
    }
    first_ = std::floor(std::log10(low));
    decades_ = std::max(1.0, std::ceil(std::log10(high)) - first_);
  }

  std::string grid() const {
    std::string svg;
    for (int k = 0; k <= static_cast<int>(decades_); ++k) {
      const double y = y_of(std::pow(10.0, first_ + k));
      svg += fmt::format(
          "<line x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#ccc\"/><text x=\"8\" "
          "y=\"{:.1f}\">1e{}</text>\n",
          kMargin, kWidth - kMargin, y, y, y + 4.0, static_cast<int>(first_) + k);
    }
    return svg;
  }

  std::string line(const std::vector<VarianceRow>& rows, const Curve& curve) const {
    std::string points;
    for (const VarianceRow& row : rows) {
      const double x = kMargin + (kWidth - 2.0 * kMargin) * row.step / steps_;
      points += fmt::format("{:.1f},{:.1f} ", x, y_of(row.*curve.value));
    }
    return points;
  }

 private:
  static constexpr double kLeast = 1e-12;
  double y_of(double variance) const {
    const double share = (std::log10(std::max(variance, kLeast)) - first_) / decades_;
    return kHeight - kMargin - (kHeight - 2.0 * kMargin) * share;
  }

  int steps_;
  double first_ = 0.0;
  double decades_ = 1.0;
};

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
  const Chart chart(options, rows);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" "
      "font-size=\"13\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n"
      "<text x=\"{2}\" y=\"22\">Variance of the gradient, {3} agents, {4} cities, {5} draws per "
      "instance</text>\n<text x=\"{6}\" y=\"{7}\">training steps (0 to {8})</text>\n",
      kWidth, kHeight, kMargin, options.agents, options.cities, options.samples,
      kWidth / 2.0 - 60.0, kHeight - 20.0, options.steps);
  svg += chart.grid();
  double legend = 44.0;
  for (const Curve& curve : kCurves) {
    svg += fmt::format(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>"
        "<text x=\"{}\" y=\"{}\" fill=\"{}\">{}</text>\n",
        chart.line(rows, curve), curve.colour, kWidth - 290.0, legend, curve.colour, curve.name);
    legend += 16.0;
  }
  return svg + "</svg>\n";
}

}  // namespace imslam::routing
