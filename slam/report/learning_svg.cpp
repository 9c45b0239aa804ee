#include "slam/report/learning_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "slam/report/axis_ticks.hpp"

namespace imslam::report {
namespace {

constexpr double kPanelWidth = 440.0;  ///< [px], all of these
constexpr double kHeight = 320.0;
constexpr double kLeft = 62.0;
constexpr double kRight = 18.0;
constexpr double kTop = 52.0;
constexpr double kBottom = 44.0;

constexpr std::string_view kStyle = R"(<style>
svg{background:#fff;font:12px system-ui,sans-serif}
.gridline{stroke:#e4e7ec}.zero{stroke:#8a93a3;stroke-dasharray:4 3}.frame{fill:none;stroke:#c9ced6}text{fill:#596273}
.title{fill:#151a23;font-weight:600;font-size:13px}
.line{fill:none;stroke-width:2;stroke-linejoin:round;stroke-linecap:round}
.accent{stroke:#2f6bff}.truth{stroke:#7d889b;stroke-dasharray:5 4}
.vo{stroke:#e8792b}.third{stroke:#14976b}.graph{stroke:#2f6bff}
@media(prefers-color-scheme:dark){svg{background:#12161d}.gridline{stroke:#252b36}.frame{stroke:#3a4250}
text{fill:#98a2b3}.title{fill:#e8ebf1}.accent,.graph{stroke:#6d9bff}.truth{stroke:#aab4c5}.vo{stroke:#f59e56}
.third{stroke:#4ccb9b}}
</style>
)";

struct Line {
  std::string label;
  const char* color;
  std::vector<double> values;  ///< NaN: none
};

struct Panel {
  std::string title;
  double x0 = 0.0;       ///< [px] of its left edge
  bool percent = false;  ///< of change: with a line at 0
  std::vector<Line> lines;
};

/// Data to pixels of one panel.
struct Scale {
  double left, low_epoch, per_epoch;
  double bottom, low, per_unit;
  double high, high_epoch;

  double x(double epoch) const { return left + (epoch - low_epoch) * per_epoch; }
  double y(double value) const { return bottom - (value - low) * per_unit; }
};

Scale fit(const Panel& panel, const std::vector<double>& epochs) {
  double low = panel.percent ? 0.0 : std::numeric_limits<double>::max();
  double high = panel.percent ? 0.0 : std::numeric_limits<double>::lowest();
  for (const Line& line : panel.lines) {
    for (const double value : line.values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  const double margin = std::max(0.08 * (high - low), 1e-6 * std::max(1.0, std::abs(high)));
  low -= margin;
  high += margin;
  const double span = std::max(epochs.back() - epochs.front(), 1e-9);
  Scale scale{};
  scale.left = panel.x0 + kLeft;
  scale.low_epoch = epochs.front();
  scale.high_epoch = epochs.back();
  scale.per_epoch = (kPanelWidth - kLeft - kRight) / span;
  scale.bottom = kHeight - kBottom;
  scale.low = low;
  scale.high = high;
  scale.per_unit = (kHeight - kTop - kBottom) / (high - low);
  return scale;
}

std::string grid(const Panel& panel, const Scale& scale) {
  const double right = panel.x0 + kPanelWidth - kRight;
  std::string out;
  const double step = round_tick(38.0 / scale.per_unit);
  for (double i = std::ceil(scale.low / step); i * step <= scale.high; ++i) {
    const double y = scale.y(i * step);
    const bool zero = panel.percent && i == 0.0;
    out += fmt::format("<line class=\"{}\" x1=\"{}\" y1=\"{:.1f}\" x2=\"{}\" y2=\"{:.1f}\"/>",
                       zero ? "zero" : "gridline", scale.left, y, right, y);
    out += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n",
                       scale.left - 6.0, y + 4.0, tick_text(i * step, step));
  }
  const double epochs = std::max(1.0, round_tick(40.0 / scale.per_epoch));
  for (double i = std::ceil(scale.low_epoch / epochs); i * epochs <= scale.high_epoch; ++i) {
    out += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                       scale.x(i * epochs), scale.bottom + 16.0, tick_text(i * epochs, epochs));
  }
  out += fmt::format("<rect class=\"frame\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
                     scale.left, kTop, right - scale.left, scale.bottom - kTop);
  return out + fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">epoch</text>\n", right,
                           kHeight - 8.0);
}

std::string path(const Line& line, const Scale& scale, const std::vector<double>& epochs) {
  std::string out = fmt::format("<path class=\"line {}\" d=\"", line.color);
  char command = 'M';
  for (std::size_t i = 0; i < std::min(epochs.size(), line.values.size()); ++i) {
    if (!std::isfinite(line.values[i])) {
      command = 'M';
      continue;
    }
    out += fmt::format("{}{:.1f} {:.1f}", command, scale.x(epochs[i]), scale.y(line.values[i]));
    command = 'L';
  }
  return out + "\"/>\n";
}

std::string drawing(const Panel& panel, const std::vector<double>& epochs) {
  const Scale scale = fit(panel, epochs);
  std::string out =
      fmt::format("<text class=\"title\" x=\"{}\" y=\"20\">{}</text>\n", scale.left, panel.title);
  double x = scale.left;
  for (const Line& line : panel.lines) {
    out += fmt::format(
        "<line class=\"line {}\" x1=\"{}\" y1=\"36\" x2=\"{}\" y2=\"36\"/>"
        "<text x=\"{}\" y=\"40\">{}</text>\n",
        line.color, x, x + 18.0, x + 23.0, line.label);
    x += 23.0 + 6.6 * static_cast<double>(line.label.size()) + 14.0;
  }
  out += grid(panel, scale);
  for (const Line& line : panel.lines) out += path(line, scale, epochs);
  return out;
}

bool has_numbers(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// [%] against the first epoch.
std::vector<double> changes(std::vector<double> values) {
  const double first = values.empty() ? 0.0 : values.front();
  for (double& value : values) {
    value = first > 0.0 ? 100.0 * (value - first) / first : std::nan("");
  }
  return values;
}

std::vector<Panel> panels(const FinetuneContent& content) {
  Panel losses{"Self-supervised loss", 0.0, false, {}};
  losses.lines.push_back({"held out", "accent", curve(content, "held_out_loss")});
  losses.lines.push_back({"learned from", "truth", curve(content, "learned_loss")});
  Panel errors{"True error against the given networks [%]", 0.0, true, {}};
  errors.lines.push_back({"VO ATE", "vo", changes(curve(content, "vo_ate_m"))});
  errors.lines.push_back({"IMU rotation", "third", changes(curve(content, "imu_rotation_deg"))});
  errors.lines.push_back({"graph ATE", "graph", changes(curve(content, "graph_ate_m"))});
  std::vector<Panel> all;
  for (Panel* panel : {&losses, &errors}) {
    auto& lines = panel->lines;
    lines.erase(std::remove_if(lines.begin(), lines.end(),
                               [](const Line& line) { return !has_numbers(line.values); }),
                lines.end());
    if (lines.empty()) continue;
    panel->x0 = kPanelWidth * static_cast<double>(all.size());
    all.push_back(std::move(*panel));
  }
  return all;
}

}  // namespace

std::string learning_svg(const FinetuneContent& content) {
  const std::vector<double> epochs = curve(content, "epoch");
  const std::vector<Panel> drawn = panels(content);
  const auto finite = [](double v) { return std::isfinite(v); };
  if (epochs.size() < 2 || drawn.empty() || !std::all_of(epochs.begin(), epochs.end(), finite)) {
    return "";
  }
  std::string out =
      fmt::format(R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {}" role="img" )"
                  R"(aria-label="Loss and errors over the epochs of a fine-tuning">)",
                  kPanelWidth * static_cast<double>(drawn.size()), kHeight);
  out += '\n';
  out += kStyle;
  for (const Panel& panel : drawn) out += drawing(panel, epochs);
  return out + "</svg>\n";
}

}  // namespace imslam::report
