#include "slam/report/finetune_page.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/report/learning_svg.hpp"
#include "slam/report/report.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::report {
namespace {

using imslam::testing::TempDir;

constexpr const char* kMetrics = R"({
  "kind": "finetune", "dataset": "<b id=evil>name</b>", "command": "imslam finetune x",
  "frames": 20, "epochs": {"wanted": 2, "done": 2}, "steps": 4, "skipped_steps": 1,
  "guard": {"verdict": "given", "text": "the given networks are the result"},
  "results": {"zero_shot": {"held_out_loss": -8.0, "vo_ate_m": 0.002, "imu_position_m": null},
              "online_adapted": null,
              "batch_adapted": {"held_out_loss": -8.5, "vo_ate_m": 0.001, "imu_position_m": null}},
  "curves": {"epoch": [0, 1, 2], "held_out_loss": [-8.0, null, -8.5], "vo_ate_m": [0.002, 0.0015, 0.001]},
  "agreement": [{"error": "vo_ate_m", "name": "VO ATE", "looks": 2, "rank_correlation": null,
                 "verdict": "unclear", "text": "too few"}],
  "models": [{"name": "match_network", "parent": "", "sha256": "ab", "command": "</script><i id=evil>"}]})";

class FinetunePage : public ::testing::Test {
 protected:
  FinetunePage() {
    dir_.write("log.csv", "step\n");
    dir_.write("metrics.json", kMetrics);
  }
  TempDir dir_;
};

TEST_F(FinetunePage, ShowsBeforeAndAfterAndNothingOfTheDataAsMarkup) {
  write_report(dir_.path());
  const std::string page = read_file(dir_.path() / "report.html");
  EXPECT_EQ(page.find("id=evil>"), std::string::npos);
  EXPECT_NE(page.find("the given networks are the result"), std::string::npos);
  EXPECT_NE(page.find("-50.0 %"), std::string::npos);
  EXPECT_EQ(page.find("online-adapted"), std::string::npos);  // there is none
  // No truth for it: its name stands in the data of the curves, but in no row.
  EXPECT_EQ(page.find("<td>IMU: position"), std::string::npos);
  EXPECT_EQ(page.find("<th>IMU: position"), std::string::npos);
  EXPECT_NE(page.find("none: began with nothing"), std::string::npos);
}

TEST_F(FinetunePage, TheDrawingLeavesGapsWhereThereIsNoNumber) {
  const std::string drawing = learning_svg(read_finetuning(dir_.path()));
  EXPECT_NE(drawing.find("held out"), std::string::npos);
  EXPECT_NE(drawing.find("VO ATE"), std::string::npos);
  EXPECT_EQ(drawing.find("graph ATE"), std::string::npos);
  EXPECT_EQ(drawing.find("nan"), std::string::npos);
  EXPECT_EQ(drawing.find("inf"), std::string::npos);
}

TEST_F(FinetunePage, ShowsSeveralSequencesOneByOneAndEachDeviceOnce) {
  auto metrics = nlohmann::json::parse(kMetrics);
  const auto sequence = [](const char* name, const char* fingerprint, double after) {
    return nlohmann::json{{"name", name},
                          {"zero_shot", {{"graph_ate_m", 0.2}}},
                          {"batch_adapted", {{"graph_ate_m", after}}},
                          {"device",
                           {{"fingerprint", fingerprint},
                            {"before", {{"disparity_offset_px", 0.0}}},
                            {"after", {{"disparity_offset_px", 0.25}}}}}};
  };
  metrics["sequences"] = {sequence("one", "aaaa", 0.1), sequence("two", "aaaa", 0.15),
                          sequence("three", "bbbb", 0.2)};
  dir_.write("metrics.json", metrics.dump());
  std::filesystem::create_directories(dir_.path() / "adapted" / "two");
  dir_.write("adapted/two/report.html", "");
  write_report(dir_.path());
  const std::string page = read_file(dir_.path() / "report.html");
  EXPECT_NE(page.find("<th>two</th>"), std::string::npos);
  EXPECT_NE(page.find("-25.0 %"), std::string::npos);
  EXPECT_NE(page.find("href=\"adapted/two/report.html\""), std::string::npos);
  EXPECT_EQ(page.find("<th>aaaa</th>"), page.rfind("<th>aaaa</th>"));
  EXPECT_NE(page.find("<th>bbbb</th>"), std::string::npos);
}

TEST_F(FinetunePage, OfAnUnfinishedFineTuningIsRefused) {
  std::filesystem::remove(dir_.path() / "metrics.json");
  EXPECT_THROW(write_report(dir_.path()), InputError);
  dir_.write("metrics.json", "{\"kind\": \"other\"}");
  EXPECT_THROW(write_report(dir_.path()), InputError);
}

}  // namespace
}  // namespace imslam::report
