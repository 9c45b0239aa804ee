// Opens reports in headless Chromium, where there is one: nothing may fail in the page.
#include <gtest/gtest.h>

#include <cstdlib>

#include "slam/base/file.hpp"
#include "slam/base/text.hpp"
#include "slam/report/report.hpp"
#include "synthetic_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::report {
namespace {

using imslam::testing::TempDir;
using report::testing::SyntheticRun;
using report::testing::write_synthetic_run;

std::string browser() {
  for (const char* name :
       {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"}) {
    if (std::filesystem::exists(name)) return name;
  }
  return "";
}

/// What the page wrote to the console, without the remarks of the software renderer.
std::string console_lines(const std::string& log) {
  std::string out;
  for (const std::string_view line : split(log, '\n')) {
    const bool console = line.find("CONSOLE") != std::string_view::npos;
    const bool renderer = line.find("GL Driver Message") != std::string_view::npos;
    if (console && !renderer) out += std::string(line) + "\n";
  }
  return out;
}

struct Page {
  std::string document;  ///< after the scripts have run
  std::string console;
};

Page open(const std::filesystem::path& file, const TempDir& work) {
  const std::string profile = (work.path() / "profile").string();
  const std::string command =
      "timeout 120 " + browser() +
      " --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-background-networking"
      " --disable-component-update --disable-sync --use-angle=swiftshader "
      "--enable-unsafe-swiftshader"
      " --virtual-time-budget=2000 --enable-logging=stderr --v=0 --user-data-dir='" +
      profile + "' --dump-dom 'file://" + file.string() + "' >'" + (work.path() / "dom").string() +
      "' 2>'" + (work.path() / "log").string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  return {read_file(work.path() / "dom"), console_lines(read_file(work.path() / "log"))};
}

class Browser : public ::testing::TestWithParam<const char*> {};

TEST_P(Browser, ShowsTheReportWithoutAConsoleMessage) {
  if (browser().empty()) GTEST_SKIP() << "no Chromium here";
  const TempDir work;
  const auto run = work.path() / "run";
  const std::string kind = GetParam();
  SyntheticRun options;
  options.dataset = "<b id=evil>name</b>";
  options.truth = options.map = kind == "whole";
  if (kind == "empty") {
    std::filesystem::create_directories(run);
  } else {
    write_synthetic_run(run, options);
  }
  write_report(run);
  const Page page = open(run / "report.html", work);
  EXPECT_EQ(page.console, "");
  EXPECT_EQ(page.document.find("<b id=\"evil\""), std::string::npos);
  EXPECT_EQ(page.document.find("class=\"hint\">No 3-D view"), std::string::npos);
  const bool plots = page.document.find("class=\"uplot") != std::string::npos;
  EXPECT_EQ(plots, kind != "empty");
  EXPECT_EQ(page.document.find("class=\"label\">ATE, SE(3) aligned") != std::string::npos,
            kind == "whole")
      << kind;
}

INSTANTIATE_TEST_SUITE_P(Runs, Browser, ::testing::Values("whole", "bare", "empty"));

}  // namespace
}  // namespace imslam::report
