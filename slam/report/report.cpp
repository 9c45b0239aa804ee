#include "slam/report/report.hpp"

#include "slam/base/file.hpp"
#include "slam/report/assets.hpp"
#include "slam/report/finetune_content.hpp"
#include "slam/report/finetune_page.hpp"
#include "slam/report/html_text.hpp"
#include "slam/report/page_data.hpp"
#include "slam/report/trajectory_svg.hpp"

namespace imslam::report {
namespace {

/// Order matters: later files use what earlier ones define.
constexpr std::string_view kScripts[] = {"dom.js",    "data.js",     "clock.js", "matrix.js",
                                         "camera.js", "painter.js",  "scene.js", "player.js",
                                         "series.js", "charts.js",   "boxes.js", "cards.js",
                                         "tables.js", "sections.js", "main.js"};

std::string script() {
  std::string out = std::string(asset("uPlot.js")) + "\n(() => {\n\"use strict\";\n";
  for (const std::string_view name : kScripts) out += asset(name);
  return out + "})();\n";
}

std::string panel_text(const std::string& text) {
  return text.empty() ? "<p class=\"empty\">Not in the run folder.</p>"
                      : "<pre>" + escape_html(text) + "</pre>";
}

}  // namespace

std::string report_html(const RunContent& run) {
  const PageData page = page_data(run);
  const std::string code = script();
  const std::string style = std::string(asset("uPlot.css")) + std::string(asset("style.css"));
  std::string notes;
  for (const std::string& note : page.notes) notes += "<li>" + escape_html(note) + "</li>\n";
  return fill_template(asset("report.html"),
                       {
                           {"script_hash", csp_hash(code)},
                           {"style_hash", csp_hash(style)},
                           {"script", code},
                           {"style", style},
                           {"data", escape_json_for_script(page.json)},
                           {"title", escape_html(page.dataset)},
                           {"name", escape_html(run.name)},
                           {"date", escape_html(page.date)},
                           {"notes", notes},
                           {"top_view", trajectory_svg(run, View::kTop, false)},
                           {"side_view", trajectory_svg(run, View::kSide, false)},
                           {"config", panel_text(run.config_yaml)},
                           {"manifest", panel_text(run.manifest_json)},
                           {"plot_license", escape_html(asset("uPlot.license"))},
                       });
}

void write_report(const std::filesystem::path& run_folder) {
  if (is_finetuning(run_folder)) return write_finetune_report(run_folder);
  const RunContent run = read_run(run_folder);
  const std::string drawing = trajectory_svg(run, View::kTop, true);
  if (!drawing.empty()) write_file_atomic(run_folder / "trajectory.svg", drawing);
  write_file_atomic(run_folder / "report.html", report_html(run));
}

}  // namespace imslam::report
