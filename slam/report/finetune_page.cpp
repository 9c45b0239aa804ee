#include "slam/report/finetune_page.hpp"

#include <fmt/format.h>

#include <cmath>

#include "slam/base/file.hpp"
#include "slam/report/assets.hpp"
#include "slam/report/finetune_cells.hpp"
#include "slam/report/finetune_sequences.hpp"
#include "slam/report/html_text.hpp"
#include "slam/report/json_text.hpp"
#include "slam/report/learning_svg.hpp"

namespace imslam::report {
namespace {

using nlohmann::json;

std::string cards(const FinetuneContent& content) {
  const json& results = at(content.metrics, "results");
  std::string out;
  for (const Measure& measure : finetune_measures()) {
    const std::string key = measure.key;
    if (key != "held_out_loss" && key != "vo_ate_m" && key != "imu_rotation_deg" &&
        key != "graph_ate_m") {
      continue;
    }
    const double before = number_at(at(results, "zero_shot"), key);
    const double after = number_at(at(results, "batch_adapted"), key);
    if (!std::isfinite(after)) continue;
    const Change change = change_of(measure, before, after);
    out += fmt::format(
        R"(<div class="card"><span class="label">{}</span><span class="value">{}<small>{}</small></span>)"
        R"(<span class="beside"><span class="chip {}">{}</span>from {}</span></div>)",
        measure.label, number_text(after), measure.unit, change.kind, escape_html(change.text),
        number_text(before));
    out += '\n';
  }
  return out;
}

std::string result_table(const FinetuneContent& content) {
  const json& results = at(content.metrics, "results");
  const bool online =
      at(results, "online_adapted").is_object() && !at(results, "online_adapted").empty();
  std::string out = "<table><thead><tr><th></th><th>zero-shot</th>" +
                    std::string(online ? "<th>online-adapted</th>" : "") +
                    "<th>batch-adapted</th><th>change</th></tr></thead><tbody>\n";
  for (const Measure& measure : finetune_measures()) {
    const double before = number_at(at(results, "zero_shot"), measure.key);
    const double after = number_at(at(results, "batch_adapted"), measure.key);
    if (!std::isfinite(before) && !std::isfinite(after)) continue;
    const Change change = change_of(measure, before, after);
    out += fmt::format("<tr><th>{} <small>{}</small></th><td>{}</td>", measure.label, measure.unit,
                       number_text(before));
    if (online) {
      out += fmt::format("<td>{}</td>",
                         number_text(number_at(at(results, "online_adapted"), measure.key)));
    }
    out += fmt::format("<td>{}</td><td><span class=\"chip {}\">{}</span></td></tr>\n",
                       number_text(after), change.kind, escape_html(change.text));
  }
  return out + "</tbody></table>";
}

std::string agreement(const FinetuneContent& content) {
  const json& all = at(content.metrics, "agreement");
  if (!all.is_array() || all.empty()) {
    return "<p class=\"empty\">The sequence has no truth to hold the loss against.</p>";
  }
  std::string table =
      "<div class=\"scroll\"><table><thead><tr><th>error</th><th>looks</th><th>rank correlation "
      "with the held-out loss</th><th></th></tr></thead><tbody>\n";
  std::string sentences;
  for (const json& each : all) {
    const std::string verdict = text_at(each, "verdict");
    const char* kind = verdict == "agree" ? "good" : verdict == "contradict" ? "bad" : "same";
    const double correlation = number_at(each, "rank_correlation");
    table += fmt::format(
        "<tr><th>{}</th><td>{}</td><td>{}</td><td><span class=\"chip {}\">{}</span></td></tr>\n",
        escape_html(text_at(each, "name")), number_text(number_at(each, "looks")),
        std::isfinite(correlation) ? fmt::format("{:+.2f}", correlation) : "–", kind,
        escape_html(verdict));
    sentences += "<li>" + escape_html(text_at(each, "text")) + "</li>\n";
  }
  return table + "</tbody></table></div><ul class=\"plain\">" + sentences + "</ul>";
}

std::string model_cards(const FinetuneContent& content) {
  const json& models = at(content.metrics, "models");
  if (!models.is_array()) return "";
  constexpr std::pair<const char*, const char*> kRows[] = {
      {"what", "What"},       {"file", "File"},     {"sha256", "sha256"},
      {"parent", "Parent"},   {"data", "Data"},     {"command", "Command"},
      {"metrics", "Metrics"}, {"limits", "Limits"}, {"seed", "Seed"},
  };
  std::string out;
  for (const json& model : models) {
    out += "<div class=\"panel model\"><h3>" + escape_html(text_at(model, "name")) + "</h3><dl>";
    for (const auto& [key, label] : kRows) {
      std::string text = text_at(model, key);
      if (text.empty() && key == std::string("parent")) text = "none: began with nothing";
      if (text.empty()) continue;
      const std::string name = key;
      const bool code = name == "sha256" || name == "parent" || name == "command" || name == "file";
      out += fmt::format("<dt>{}</dt><dd{}>{}</dd>\n", label, code ? " class=\"code\"" : "",
                         escape_html(text));
    }
    out += "</dl></div>\n";
  }
  return out;
}

std::string facts(const FinetuneContent& content) {
  const json& metrics = content.metrics;
  const json& epochs = at(metrics, "epochs");
  const auto fact = [](const std::string& value, const char* what) {
    return "<li><b>" + escape_html(value) + "</b> " + what + "</li>\n";
  };
  const double done = number_at(epochs, "done");
  const double wanted = number_at(epochs, "wanted");
  std::string out = fact(number_text(number_at(metrics, "frames")), "frames");
  out += fact(done == wanted ? number_text(done) : number_text(done) + " of " + number_text(wanted),
              "epochs");
  out += fact(number_text(number_at(metrics, "steps")), "steps");
  out += fact(number_text(number_at(metrics, "skipped_steps")), "skipped steps");
  const std::string left_out = text_at(metrics, "left_out");
  if (!left_out.empty()) out += "<li>left out: " + escape_html(left_out) + "</li>\n";
  return out;
}

std::string run_links(const FinetuneContent& content) {
  std::string out;
  for (const std::string& run : content.runs) {
    const bool adapted = run.rfind("adapted", 0) == 0;
    out += fmt::format(
        "<a class=\"panel run\" href=\"{}/report.html\"><b>{}</b><span>{}</span></a>",
        escape_html(run), adapted ? "Adapted run" : "Zero-shot run",
        adapted ? "with the networks in weights/" : "with the networks as they were given");
  }
  return out.empty() ? "<p class=\"empty\">Not in the folder.</p>" : out;
}

/// Measures and curves in the form that template/finetune.js reads.
std::string script_data(const FinetuneContent& content) {
  json measures = json::array();
  for (const Measure& each : finetune_measures()) {
    measures.push_back(
        {{"key", each.key}, {"label", each.label}, {"unit", each.unit}, {"color", each.color}});
  }
  const json data = {{"measures", measures}, {"curves", at(content.metrics, "curves")}};
  return data.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

std::string finetune_html(const FinetuneContent& content) {
  std::string code = std::string(asset("uPlot.js")) + "\n(() => {\n\"use strict\";\n";
  for (const char* name : {"dom.js", "series.js", "sections.js", "finetune.js"})
    code += asset(name);
  code += "})();\n";
  const std::string style = std::string(asset("uPlot.css")) + std::string(asset("style.css")) +
                            std::string(asset("finetune.css"));
  const json& guard = at(content.metrics, "guard");
  const std::string verdict = text_at(guard, "verdict");
  return fill_template(asset("finetune.html"),
                       {{"script_hash", csp_hash(code)},
                        {"style_hash", csp_hash(style)},
                        {"script", code},
                        {"style", style},
                        {"data", escape_json_for_script(script_data(content))},
                        {"title", escape_html(text_at(content.metrics, "dataset"))},
                        {"name", escape_html(content.name)},
                        {"command", escape_html(text_at(content.metrics, "command"))},
                        {"facts", facts(content)},
                        {"verdict_kind", verdict == "adapted" ? "good" : "careful"},
                        {"verdict", escape_html(text_at(guard, "text"))},
                        {"cards", cards(content)},
                        {"results", result_table(content) + sequences_table(content)},
                        {"device", device_table(content)},
                        {"agreement", agreement(content)},
                        {"models", model_cards(content)},
                        {"runs", run_links(content)},
                        {"config", escape_html(content.config_yaml)},
                        {"plot_license", escape_html(asset("uPlot.license"))}});
}

void write_finetune_report(const std::filesystem::path& folder) {
  const FinetuneContent content = read_finetuning(folder);
  const std::string drawing = learning_svg(content);
  if (!drawing.empty()) write_file_atomic(folder / "learning.svg", drawing);
  write_file_atomic(folder / "report.html", finetune_html(content));
}

}  // namespace imslam::report
