#include "slam/report/trajectory_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "slam/report/axis_ticks.hpp"
#include "slam/report/thinning.hpp"

namespace imslam::report {
namespace {

constexpr double kWidth = 640.0;  ///< [px], all of these
constexpr double kHeight = 420.0;
constexpr double kLeft = 52.0;
constexpr double kRight = 16.0;
constexpr double kTop = 16.0;
constexpr double kBottom = 40.0;
constexpr std::size_t kMaxVertices = 3000;

constexpr std::string_view kStyle = R"(<style>
svg{background:#fff;font:12px system-ui,sans-serif}
.gridline{stroke:#e4e7ec}.frame{fill:none;stroke:#c9ced6}text{fill:#596273}
.line{fill:none;stroke-linejoin:round;stroke-linecap:round}
.truth{stroke:#c3cad6;stroke-width:7}
.vo{stroke:#e8833a;stroke-width:1.5}.graph{stroke:#2f6bff;stroke-width:2}
.start{fill:#1aa06d}.end{fill:#d6455d}
@media(prefers-color-scheme:dark){svg{background:#12161d}.gridline{stroke:#252b36}.frame{stroke:#3a4250}
text{fill:#98a2b3}.truth{stroke:#4a5568}.vo{stroke:#f59e56}.graph{stroke:#6d9bff}}
</style>
)";

/// Metres to pixels, and what is visible.
struct Scale {
  double scale = 1.0;  ///< [px/m]
  double x0 = 0.0;     ///< [px] of horizontal = 0
  double y0 = 0.0;     ///< [px] of vertical = 0

  double x(double horizontal) const { return x0 + scale * horizontal; }
  double y(double vertical) const { return y0 - scale * vertical; }
};

Eigen::Vector2d seen(const Trajectory& trajectory, std::size_t i, View view) {
  const Eigen::Vector3d& p = trajectory.poses[i].translation();
  return {p.x(), view == View::kTop ? p.y() : p.z()};
}

std::array<std::pair<const char*, const Trajectory*>, 3> layers(const RunContent& run) {
  return {{{"truth", &run.truth}, {"vo", &run.vo}, {"graph", &run.graph}}};
}

Scale fit(const RunContent& run, View view) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
  Eigen::Vector2d high = -low;
  for (const auto& [name, trajectory] : layers(run)) {
    for (std::size_t i = 0; i < trajectory->size(); ++i) {
      low = low.cwiseMin(seen(*trajectory, i, view));
      high = high.cwiseMax(seen(*trajectory, i, view));
    }
  }
  const Eigen::Vector2d extent = (high - low).cwiseMax(0.1) * 1.08;
  const Eigen::Vector2d center = 0.5 * (low + high);
  Scale scale;
  scale.scale =
      std::min((kWidth - kLeft - kRight) / extent.x(), (kHeight - kTop - kBottom) / extent.y());
  scale.x0 = 0.5 * (kLeft + kWidth - kRight) - scale.scale * center.x();
  scale.y0 = 0.5 * (kTop + kHeight - kBottom) + scale.scale * center.y();
  return scale;
}

std::string grid(const Scale& scale, View view) {
  const double step = round_tick(60.0 / scale.scale);
  std::string out;
  const double right = kWidth - kRight;
  const double bottom = kHeight - kBottom;
  for (double i = std::ceil((kLeft - scale.x0) / scale.scale / step); scale.x(i * step) <= right;
       ++i) {
    const double x = scale.x(i * step);
    out += fmt::format(R"(<line class="gridline" x1="{0:.1f}" y1="{1}" x2="{0:.1f}" y2="{2}"/>)", x,
                       kTop, bottom);
    out += fmt::format(R"(<text x="{:.1f}" y="{}" text-anchor="middle">{}</text>)", x, bottom + 16,
                       tick_text(i * step, step));
    out += '\n';
  }
  for (double i = std::ceil((scale.y0 - bottom) / scale.scale / step); scale.y(i * step) >= kTop;
       ++i) {
    const double y = scale.y(i * step);
    out += fmt::format(R"(<line class="gridline" x1="{1}" y1="{0:.1f}" x2="{2}" y2="{0:.1f}"/>)", y,
                       kLeft, right);
    out += fmt::format(R"(<text x="{}" y="{:.1f}" text-anchor="end">{}</text>)", kLeft - 6, y + 4,
                       tick_text(i * step, step));
    out += '\n';
  }
  out += fmt::format(R"(<rect class="frame" x="{}" y="{}" width="{}" height="{}"/>)", kLeft, kTop,
                     right - kLeft, bottom - kTop);
  out += fmt::format(R"(<text x="{}" y="{}" text-anchor="end">x [m]</text>)", right, kHeight - 6);
  out += fmt::format(
      R"svg(<text x="{0}" y="{1}" transform="rotate(-90 {0} {1})" text-anchor="end">{2} [m]</text>)svg",
      13, kTop, view == View::kTop ? "y" : "z");
  return out + '\n';
}

std::string path(const Trajectory& trajectory, const char* name, const Scale& scale, View view) {
  std::string out = fmt::format(R"(<path class="line {}" d=")", name);
  char command = 'M';
  for (const std::size_t i : spread(trajectory.size(), kMaxVertices)) {
    const Eigen::Vector2d p = seen(trajectory, i, view);
    out += fmt::format("{}{:.1f} {:.1f}", command, scale.x(p.x()), scale.y(p.y()));
    command = 'L';
  }
  return out + "\"/>\n";
}

std::string dot(
    const Trajectory& trajectory, std::size_t i, const char* name, const Scale& scale, View view) {
  const Eigen::Vector2d p = seen(trajectory, i, view);
  return fmt::format(
      R"(<circle class="{0}" cx="{1:.1f}" cy="{2:.1f}" r="4.5"><title>{0}</title></circle>)", name,
      scale.x(p.x()), scale.y(p.y()));
}

}  // namespace

std::string trajectory_svg(const RunContent& run, View view, bool standalone) {
  const Trajectory* marked = nullptr;
  for (const auto& [name, trajectory] : layers(run)) {
    if (trajectory->size() > 0) marked = trajectory;
  }
  if (marked == nullptr) return "";
  const Scale scale = fit(run, view);
  std::string out = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {}" class="view" role="img" )"
      R"(aria-label="{} view of the trajectories" data-scale="{:.9g}" data-x0="{:.9g}" data-y0="{:.9g}">)",
      kWidth, kHeight, view == View::kTop ? "Top" : "Side", scale.scale, scale.x0, scale.y0);
  out += '\n';
  if (standalone) out += kStyle;
  out += grid(scale, view);
  for (const auto& [name, trajectory] : layers(run)) {
    if (trajectory->size() > 0) out += path(*trajectory, name, scale, view);
  }
  out += dot(*marked, 0, "start", scale, view);
  out += dot(*marked, marked->size() - 1, "end", scale, view);
  return out + "\n</svg>\n";
}

}  // namespace imslam::report
