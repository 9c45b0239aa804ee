#include "slam/report/report.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/report/html_text.hpp"
#include "slam/report/page_data.hpp"
#include "slam/report/trajectory_svg.hpp"
#include "synthetic_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::report {
namespace {

using imslam::testing::TempDir;
using nlohmann::json;
using report::testing::SyntheticRun;
using report::testing::write_synthetic_run;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++found;
  return found;
}

/// The text between the `opening` and the next `closing`.
std::string between(const std::string& text,
                    const std::string& opening,
                    const std::string& closing) {
  const std::size_t begin = text.find(opening);
  if (begin == std::string::npos) return "";
  const std::size_t from = begin + opening.size();
  return text.substr(from, text.find(closing, from) - from);
}

json embedded_data(const std::string& html) {
  return json::parse(between(html, "id=\"data\">", "</script>"));
}

TEST(Report, HoldsTheWholeRunInOneFile) {
  const TempDir folder;
  write_synthetic_run(folder.path());
  write_report(folder.path());
  const std::string html = read_file(folder.path() / "report.html");
  const json data = embedded_data(html);
  EXPECT_EQ(data["dataset"], "synthetic_room");
  EXPECT_EQ(data["date"], "2025-03-14 15:09:26");
  EXPECT_TRUE(data["notes"].empty()) << data["notes"];
  for (const char* name : {"graph", "vo", "truth"})
    EXPECT_EQ(data["trajectories"][name]["count"], 1200);
  EXPECT_EQ(data["map"]["count"], 48000);
  EXPECT_EQ(data["rpe"].size(), 4U);
  EXPECT_EQ(data["rpe"][3]["length_m"], 10.0) << "sorted as numbers, not as texts";
  EXPECT_EQ(data["metrics"]["frames"], 1200);
  EXPECT_NE(html.find("window_px: 21"), std::string::npos);
  EXPECT_NE(html.find("Copyright (c) 2022 Leon Sorokin"), std::string::npos);
  EXPECT_LT(html.size(), 1500000U);
}

TEST(Report, LoadsNothing) {
  const TempDir folder;
  write_synthetic_run(folder.path());
  std::string html = report_html(read_run(folder.path()));
  const std::string policy = between(html, "Security-Policy\" content=\"", "\"");
  EXPECT_EQ(policy.rfind("default-src 'none'; script-src 'sha256-", 0), 0U) << policy;
  EXPECT_EQ(policy.find("unsafe"), std::string::npos) << policy;
  for (const char* loads : {"<link", "<iframe", "<img", " src=", "@import", "url(", "fetch(",
                            "XMLHttpRequest", "WebSocket", "sendBeacon", "import("}) {
    EXPECT_EQ(html.find(loads), std::string::npos) << loads;
  }
  for (std::size_t at = html.find("://"); at != std::string::npos; at = html.find("://", at + 1)) {
    const std::size_t begin = html.find_last_of(" \"'\n", at) + 1;
    const std::string address = html.substr(begin, html.find_first_of(" \"'\n", at) - begin);
    EXPECT_TRUE(address == "http://www.w3.org/2000/svg" ||
                address == "https://github.com/leeoniya/uPlot")
        << address;
  }
}

TEST(Report, PolicyAllowsExactlyItsOwnScriptAndStyle) {
  const std::string html = report_html(RunContent{});
  const std::string policy = between(html, "Security-Policy\" content=\"", "\"");
  EXPECT_NE(policy.find("script-src " + csp_hash(between(html, "<script>", "</script>")) + ";"),
            std::string::npos);
  EXPECT_NE(policy.find("style-src " + csp_hash(between(html, "<style>", "</style>")) + ";"),
            std::string::npos);
}

TEST(Report, NothingInTheDataBecomesMarkup) {
  const std::string evil =
      "</script></title></pre><script>alert(1)</script><img src=x onerror=alert(2)>";
  const TempDir folder;
  SyntheticRun options;
  options.dataset = evil;
  options.frames = 50;
  write_synthetic_run(folder.path(), options);
  folder.write("config.yaml", evil);
  folder.write("manifest.json", json{{"date", evil}}.dump());
  folder.write("truth.tum", evil);  // its name and content turn up in a note
  folder.write("series.json", json{{"columns", {{"time_s", {0, 1}}, {evil, {1}}}}}.dump());
  RunContent run = read_run(folder.path());
  run.name = evil;
  const std::string html = report_html(run);
  EXPECT_EQ(count(html, "<script"), 2U);
  EXPECT_EQ(count(html, "</script"), 2U);
  EXPECT_EQ(count(html, "</title>"), count(report_html(RunContent{}), "</title>") + 4)
      << "of the drawings";
  EXPECT_EQ(html.find("<img"), std::string::npos);
  EXPECT_EQ(embedded_data(html)["dataset"], evil) << "still complete in the data";
}

TEST(Report, SameRunGivesSameBytes) {
  const TempDir folder;
  write_synthetic_run(folder.path());
  write_report(folder.path());
  const std::string first = sha256_of_file(folder.path() / "report.html");
  const std::string drawing = sha256_of_file(folder.path() / "trajectory.svg");
  write_report(folder.path());
  EXPECT_EQ(sha256_of_file(folder.path() / "report.html"), first);
  EXPECT_EQ(sha256_of_file(folder.path() / "trajectory.svg"), drawing);
}

TEST(Report, AnyFileMayBeMissing) {
  const TempDir whole;
  SyntheticRun options;
  options.frames = 60;
  write_synthetic_run(whole.path(), options);
  for (const char* name : {"metrics.json", "series.json", "trajectory.tum", "vo_only.tum",
                           "truth.tum", "map.pcd", "config.yaml", "manifest.json"}) {
    const std::string kept = read_file(whole.path() / name);
    std::filesystem::remove(whole.path() / name);
    EXPECT_NO_THROW(write_report(whole.path())) << name;
    whole.write(name, kept);
  }
}

TEST(Report, EmptyFolderGivesAReportThatSaysSo) {
  const TempDir folder;
  write_report(folder.path());
  const std::string html = read_file(folder.path() / "report.html");
  EXPECT_NE(html.find("trajectory.tum is not in the run folder"), std::string::npos);
  EXPECT_NE(html.find("metrics.json is not in the run folder"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "trajectory.svg"));
}

TEST(Report, MissingFolderIsTheUsersMistake) {
  EXPECT_THROW(write_report("/nonexistent/run"), InputError);
}

TEST(Report, UnwritableFolderIsAnOutputError) {
  const TempDir folder;
  std::filesystem::create_directories(folder.path() / "report.html" / "in_the_way");
  try {
    write_report(folder.path());
    FAIL() << "expected InputError";
  } catch (const InputError& problem) {
    EXPECT_EQ(problem.code(), ExitCode::kOutput);
  }
}

TEST(Report, DamagedFilesBecomeNotes) {
  const TempDir folder;
  SyntheticRun options;
  options.frames = 40;
  write_synthetic_run(folder.path(), options);
  folder.write("metrics.json", "{\"frames\": ");
  folder.write("series.json", "[1, 2]");
  folder.write("truth.tum", "1 2 3\n");
  folder.write("map.pcd", "nonsense");
  const json notes = embedded_data(report_html(read_run(folder.path())))["notes"];
  const std::string all = notes.dump();
  EXPECT_EQ(notes.size(), 4U) << all;
  EXPECT_NE(all.find("metrics.json: expected JSON"), std::string::npos) << all;
  EXPECT_NE(all.find("series.json was left out: expected an object"), std::string::npos) << all;
  EXPECT_NE(all.find("truth.tum:1: expected 8 numbers"), std::string::npos) << all;
  EXPECT_NE(all.find("map.pcd"), std::string::npos) << all;
}

TEST(Report, DeepJsonIsRefusedBeforeItExhaustsTheStack) {
  RunContent run;
  run.metrics_json = "{\"a\":" + std::string(200000, '[') + std::string(200000, ']') + "}";
  const PageData page = page_data(run);
  ASSERT_EQ(page.notes.size(), 1U);
  EXPECT_NE(page.notes[0].find("32 nested levels"), std::string::npos) << page.notes[0];
}

TEST(Report, NumbersThatDoNotExistBecomeGaps) {
  RunContent run;
  run.series_json =
      R"({"columns": {"time_s": [0, 1, 2], "a": [null, 1e300, 2.5], "b": [1], "c": "x"},
                        "rpe": {"graph": {"1": [null, 3, 1], "2": [], "x": [1]}, "vo": 7}})";
  const PageData page = page_data(run);
  const json data = json::parse(page.json);
  EXPECT_EQ(data["series"]["a"], "AADAfwAAwH8AACBA") << "NaN NaN 2.5 as little-endian float32";
  EXPECT_FALSE(data["series"].contains("b"));
  EXPECT_FALSE(data["series"].contains("c"));
  EXPECT_EQ(page.notes.size(), 2U);
  ASSERT_EQ(data["rpe"].size(), 2U);
  EXPECT_EQ(data["rpe"][0]["graph"]["median"], 2.0);
  EXPECT_TRUE(data["rpe"][1]["graph"].is_null());
}

TEST(Report, PosesThatAreNotFiniteAreLeftOutAndCounted) {
  const TempDir folder;
  folder.write(
      "trajectory.tum",
      "# comment\n1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n3 1 0 0 0 0 0 0\n3.5 1e300 0 0 0 0 0 1\n"
      "4 1 2 3 0 0 0 2\n4 9 9 9 0 0 0 1\n5 2 0 0 0 0 0 1\n");
  std::size_t skipped = 0;
  const Trajectory trajectory = read_tum(folder.path() / "trajectory.tum", &skipped);
  ASSERT_EQ(trajectory.size(), 3U);
  EXPECT_EQ(skipped, 4U);
  EXPECT_EQ(trajectory.times_ns[1], 4000000000);
  EXPECT_EQ(trajectory.poses[1].translation(), Eigen::Vector3d(1, 2, 3));
  const json data = embedded_data(report_html(read_run(folder.path())));
  EXPECT_NE(data["notes"].dump().find("4 lines without a valid pose"), std::string::npos);
  EXPECT_EQ(json::parse(data.dump()), data);
}

TEST(Report, LongRunsAreThinnedToABoundedSize) {
  RunContent run;
  json columns;
  for (int i = 0; i < 100000; ++i) {
    run.graph.add(std::int64_t{50000000} * i, lie::SE3d(lie::SO3d(), {0.01 * i, 1.0, 2.0}));
    for (const char* name : {"time_s", "inliers", "graph_error_m"})
      columns[name].push_back(0.05 * i);
  }
  run.series_json = json{{"columns", columns}}.dump();
  const std::string html = report_html(run);
  EXPECT_EQ(embedded_data(html)["trajectories"]["graph"]["count"], kMaxRows);
  EXPECT_LT(html.size(), 2000000U);
}

TEST(Report, FarFromTheOriginPositionsKeepTheirMillimetres) {
  RunContent run;
  for (int i = 0; i < 3; ++i) {
    run.graph.add(1700000000000000000 + std::int64_t{50000000} * i,
                  lie::SE3d(lie::SO3d(), {5e6 + 0.001 * i, 0, 0}));
  }
  const json data = json::parse(page_data(run).json);
  EXPECT_EQ(data["origin"][0], 5e6);
  const std::vector<float> expected = {0,
                                       0,
                                       0,
                                       static_cast<float>((5e6 + 0.001) - 5e6),
                                       0,
                                       0,
                                       static_cast<float>((5e6 + 0.002) - 5e6),
                                       0,
                                       0};
  EXPECT_EQ(data["trajectories"]["graph"]["position"], base64(expected));
  EXPECT_EQ(data["trajectories"]["graph"]["time"], base64(std::vector<float>{0, 0.05F, 0.1F}));
}

TEST(TrajectorySvg, PutsPosesWhereItsAttributesSay) {
  RunContent run;
  run.graph.add(0, lie::SE3d(lie::SO3d(), {-3, -1, 7}));
  run.graph.add(1, lie::SE3d(lie::SO3d(), {5, 2, 9}));
  const std::string svg = trajectory_svg(run, View::kSide, true);
  const auto attribute = [&](const std::string& name) {
    return std::stod(between(svg, "data-" + name + "=\"", "\""));
  };
  const std::string path = between(svg, "class=\"line graph\" d=\"M", "\"");
  const double x = std::stod(path);
  const double y = std::stod(path.substr(path.find(' ')));
  EXPECT_NEAR(x, attribute("x0") + attribute("scale") * -3, 0.06);
  EXPECT_NEAR(y, attribute("y0") - attribute("scale") * 7, 0.06);
  EXPECT_GT(x, 0.0);
  EXPECT_GT(y, 0.0);
}

TEST(TrajectorySvg, StandsStillWithoutSpanAndWithoutPoses) {
  RunContent run;
  EXPECT_EQ(trajectory_svg(run, View::kTop, true), "");
  run.vo.add(0, lie::SE3d());
  const std::string svg = trajectory_svg(run, View::kTop, true);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_NE(svg.find("class=\"line vo\""), std::string::npos);
}

TEST(TrajectorySvg, DrawsAWorldOfAnySize) {
  for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e8}) {
    RunContent run;
    run.graph.add(0, lie::SE3d());
    run.graph.add(1, lie::SE3d(lie::SO3d(), {size, size, 0}));
    const std::string svg = trajectory_svg(run, View::kTop, false);
    EXPECT_LT(svg.size(), 10000U) << size;
    EXPECT_GT(count(svg, "class=\"gridline\""), 4U) << size;
  }
}

}  // namespace
}  // namespace imslam::report
