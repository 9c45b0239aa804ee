// `imslam bench` on small stand-ins with the layouts of EuRoC and KITTI.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "slam/base/process_group.hpp"
#include "tests/support/command.hpp"
#include "tests/support/tiny_dataset.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using testing::quoted;
using testing::run_imslam;
using testing::slurp;

class BenchCommand : public ::testing::Test {
 protected:
  BenchCommand() {
    testing::TinyWorld world;
    testing::write_tiny_euroc(dir_.path() / "data" / "A_01", world);
    world.sway = 0.8;
    testing::write_tiny_euroc(dir_.path() / "data" / "A_02", world);
    testing::write_tiny_kitti(dir_.path() / "data", world, "07");
    write_suite("euroc", "A_01", "A_02", "sequences/07");
  }

  void write_suite(const std::string& metric,
                   const std::string& a,
                   const std::string& b,
                   const std::string& c) {
    suite_ = dir_.write("suite.yaml", "name: Stand-in\nmetric: " + metric +
                                          "\nroot: data\nsequences:\n  - {name: a, path: " + a +
                                          "}\n  - {name: b, path: " + b +
                                          "}\n  - {name: c, path: " + c + "}\n");
  }

  testing::CommandResult bench(const std::string& arguments,
                               const std::string& out = "out",
                               const std::string& before = "") {
    return run_imslam(
        dir_, "bench " + quoted(suite_.string()) + " --out " + quoted(file(out)) + " " + arguments,
        before);
  }
  std::string file(const std::string& name) const { return (dir_.path() / name).string(); }

  testing::TempDir dir_;
  fs::path suite_;
};

TEST_F(BenchCommand, PrintsOneTableAndKeepsAllRuns) {
  const auto result = bench("--quiet");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out, slurp(file("out/table.txt")));
  EXPECT_EQ(result.out.find(" - "), std::string::npos) << result.out;
  for (const char* name : {"out/table.csv", "out/table.tex", "out/vision/a/report.html",
                           "out/inertial/c/trajectory.tum"}) {
    EXPECT_TRUE(fs::exists(file(name))) << name;
  }
  // The row without IMU must not have seen it.
  const auto metrics = nlohmann::json::parse(slurp(file("out/vision/a/metrics.json")));
  EXPECT_FALSE(metrics.at("inertial").get<bool>());
}

TEST_F(BenchCommand, ProcessesChangeNoByte) {
  const auto one = bench("--quiet --variants vo", "one");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const auto two = bench("--quiet --variants vo --jobs 2", "two");
  ASSERT_EQ(two.exit_code, 0) << two.err;
  EXPECT_EQ(one.out, two.out);
  EXPECT_EQ(slurp(file("one/table.csv")), slurp(file("two/table.csv")));
  EXPECT_EQ(slurp(file("one/vision/b/trajectory.tum")), slurp(file("two/vision/b/trajectory.tum")));
}

TEST_F(BenchCommand, MpiChangesNoByte) {
  if (!built_with_mpi()) GTEST_SKIP() << "built without MPI";
  if (std::system("command -v mpirun >/dev/null 2>&1") != 0) GTEST_SKIP() << "no mpirun here";
  ASSERT_EQ(bench("--quiet --variants vo", "alone").exit_code, 0);
  for (const char* ranks : {"2", "4"}) {
    const auto result =
        bench("--quiet --variants vo", std::string("mpi") + ranks,
              std::string("mpirun --allow-run-as-root --oversubscribe -n ") + ranks);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, slurp(file("alone/table.txt"))) << ranks;
  }
}

TEST_F(BenchCommand, EarlierRunsAreUsedOnlyForTheSameOptionsAndData) {
  const auto made = [&] { return fs::last_write_time(file("out/vision/a/suite.json")); };
  const std::string only_vo = "--variants vo ";
  const auto first = bench(only_vo);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  auto before = made();
  const auto again = bench(only_vo);
  EXPECT_EQ(made(), before);
  EXPECT_EQ(again.out, first.out);
  EXPECT_NE(again.err.find("earlier run"), std::string::npos) << again.err;

  ASSERT_EQ(bench(only_vo + "--set pgo.huber=2").exit_code, 0);
  EXPECT_NE(made(), before);
  before = made();
  ASSERT_EQ(bench(only_vo + "--set pgo.huber=2 --force").exit_code, 0);
  EXPECT_NE(made(), before);
  before = made();
  const fs::path image = fs::directory_iterator(file("data/A_01/mav0/cam0/data"))->path();
  fs::resize_file(image, fs::file_size(image) + 1);
  ASSERT_EQ(bench(only_vo + "--set pgo.huber=2").exit_code, 0);
  EXPECT_NE(made(), before);
}

TEST_F(BenchCommand, WhatIsMissingIsADashAndACodeNotTheEnd) {
  fs::remove_all(file("data/A_01"));
  fs::remove(file("data/sequences/07/imu.csv"));
  const auto result = bench("");
  EXPECT_EQ(result.exit_code, 3) << result.err;
  EXPECT_NE(result.out.find("a: A_01 is not there\n"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("c, imslam zero-shot, with IMU: no IMU data\n"), std::string::npos)
      << result.out;
  EXPECT_NE(result.out.find(" *\n"), std::string::npos) << result.out;
}

TEST_F(BenchCommand, ShortPathsHaveNoDrift) {
  write_suite("kitti", "A_01", "A_02", "sequences/07");
  const auto result = bench("--variants vo");
  EXPECT_EQ(result.exit_code, 8) << result.err;
  EXPECT_NE(result.out.find("a: the path is shorter than 100 m"), std::string::npos) << result.out;
}

TEST_F(BenchCommand, TheRootComesFromOptionThenEnvironmentThenFile) {
  const auto list = [&](const std::string& arguments, const std::string& before) {
    return bench("--list " + arguments, "out", before).out;
  };
  fs::create_directories(file("other"));
  EXPECT_NE(list("", "").find("a: " + file("data")), std::string::npos) << list("", "");
  const std::string environment = "IMSLAM_SUITE_ROOT=" + quoted(file("other"));
  EXPECT_NE(list("", environment).find("a: not there"), std::string::npos);
  EXPECT_NE(list("--root " + quoted(file("data")), environment).find("a: " + file("data")),
            std::string::npos);
}

TEST_F(BenchCommand, WrongUseIsToldBeforeAnyWork) {
  EXPECT_EQ(bench("--variants vo,grpah").exit_code, 2);
  EXPECT_EQ(bench("--jobs 0").exit_code, 2);
  EXPECT_EQ(bench("--set system.imu=off").exit_code, 2);
  EXPECT_EQ(bench("--root " + quoted(file("nowhere"))).exit_code, 3);
  suite_ = dir_.write("bad.yaml", "name: x\nmetric: euroc\nsequence: []\n");
  const auto result = bench("");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("bad.yaml:3: unknown key 'sequence'"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(file("out/table.txt")));
}

}  // namespace
}  // namespace imslam
