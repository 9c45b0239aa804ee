#include "datasets/trajectory_file.hpp"

#include <gtest/gtest.h>

#include <string>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "tests/datasets/expect_error.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::datasets {
namespace {

using imslam::testing::expect_near;
using imslam::testing::TempDir;

constexpr const char* kTumLine = "1403636580.05 1 2 3 0 0 0.7071067811865476 0.7071067811865476\n";
constexpr const char* kKittiLine = "1 0 0 4 0 1 0 5 0 0 1 6\n";
constexpr const char* kEurocLine =
    "1403636580050000000,1,2,3,0.7071067811865476,0,0,0.7071067811865476\n";

Trajectory some_trajectory() {
  Trajectory trajectory;
  trajectory.frame = "left";
  for (int i = 0; i < 20; ++i) {
    lie::SE3d::Tangent tau;
    tau << 1e3 / (i + 1), -1e-9 * i, 0.1 * i, 0.3 * i, -1.0 / 3.0, 1e-7;
    trajectory.add(1403636579763555584 + 50'000'001 * i, lie::SE3d::exp(tau));
  }
  return trajectory;
}

TEST(TrajectoryFile, DetectsTheFormatFromTheFirstDataLine) {
  const TempDir folder;
  const auto detect = [&](const std::string& text) {
    return detect_trajectory_format(folder.write("t.txt", text));
  };
  EXPECT_EQ(detect(std::string("# comment\n\n") + kTumLine), TrajectoryFormat::kTum);
  EXPECT_EQ(detect(kKittiLine), TrajectoryFormat::kKitti);
  EXPECT_EQ(detect(std::string("#timestamp [ns],x\n") + kEurocLine), TrajectoryFormat::kEuroc);
}

TEST(TrajectoryFile, ReadsTheSamePoseFromTumAndEuroc) {
  const TempDir folder;
  const PosePath tum = read_trajectory(folder.write("a.tum", kTumLine));
  const PosePath euroc = read_trajectory(folder.write("a.csv", kEurocLine));
  ASSERT_EQ(tum.size(), 1U);
  EXPECT_EQ(tum.stamps_s, euroc.stamps_s);
  expect_near(tum.poses[0], euroc.poses[0], 0.0);
  Eigen::Matrix4d expected;  // a quarter turn about z
  expected << 0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1;
  expect_near(tum.poses[0], expected, 1e-15);
}

TEST(TrajectoryFile, KeepsKittiMatricesAsTheyAre) {
  const TempDir folder;
  const PosePath path = read_trajectory(folder.write("00.txt", "1.001 0 0 4 0 1 0 5 0 0 1 6\n"));
  EXPECT_FALSE(path.has_stamps());
  EXPECT_EQ(path.poses[0](0, 0), 1.001);
  EXPECT_EQ(path.poses[0](2, 3), 6.0);
}

TEST(TrajectoryFile, AcceptsWhatOtherProgramsWrite) {
  const TempDir folder;
  const std::string tum = kTumLine;
  const std::string trailing = tum.substr(0, tum.size() - 1) + " \t\r\n";
  for (const std::string& text :
       {"\xEF\xBB\xBF" + tum, trailing, "\n\n# x\n" + tum + "#y\n\n", tum.substr(0, tum.size() - 1),
        "  " + tum,
        std::string("1403636580.05\t1\t+2\t3e0 0 0 0.7071067811865476 0.7071067811865476")}) {
    EXPECT_EQ(read_trajectory(folder.write("t.tum", text)).size(), 1U) << text;
  }
  EXPECT_EQ(read_trajectory(folder.write("t.csv", "1,1,2,3,1,0,0,0,\n")).size(), 1U);
  EXPECT_EQ(read_trajectory(folder.write("t.csv", "1, 1, 2, 3, 1, 0, 0, 0, 9, 9, 9\n")).size(), 1U);
}

TEST(TrajectoryFile, NormalisesQuaternions) {
  const TempDir folder;
  const PosePath path = read_trajectory(folder.write("t.tum", "0 1 2 3 0 0 0 -0.5\n"));
  expect_near(path.poses[0].topLeftCorner<3, 3>(), Eigen::Matrix3d::Identity(), 0.0);
}

struct BadFile {
  const char* text;
  int line;
  const char* reason;
  ExitCode code;
};

TEST(TrajectoryFile, NamesFileLineAndReasonOfBadInput) {
  const std::string good = kTumLine;
  const std::string cut = good + "1403636580.10 1 2\n";
  const std::string word = good + "# c\n1403636580.10 1 2 x 0 0 0 1\n";
  const std::string nan = good + "1403636580.10 1 nan 3 0 0 0 1\n";
  const std::string huge = good + "1403636580.10 1 1e999 3 0 0 0 1\n";
  const std::string zero = good + "1403636580.10 1 2 3 0 0 0 0\n";
  const std::string mixed = good + kKittiLine;
  const std::string decimal_comma = "0 1,5 2 3 0 0 0 1\n";
  const std::string endless = good + std::string(70000, '1');
  const BadFile cases[] = {
      {"1 2 3\n", 1, "expected 8 blank-separated columns", ExitCode::kData},
      {"1,2,3\n", 1, "expected at least 8 comma-separated columns", ExitCode::kData},
      {cut.c_str(), 2, "expected 8 columns", ExitCode::kData},
      {word.c_str(), 3, "column 4: expected a number, found 'x'", ExitCode::kData},
      {nan.c_str(), 2, "column 3: nan is not a pose", ExitCode::kEvaluation},
      {huge.c_str(), 2, "column 3: expected a number", ExitCode::kData},
      {zero.c_str(), 2, "the quaternion is zero", ExitCode::kEvaluation},
      {mixed.c_str(), 2, "expected 8 columns", ExitCode::kData},
      {decimal_comma.c_str(), 1, "comma-separated", ExitCode::kData},
      {endless.c_str(), 2, "longer than 64 kB", ExitCode::kData},
  };
  for (const BadFile& bad : cases) {
    const TempDir folder;
    const auto file = folder.write("bad.txt", bad.text);
    try {
      read_trajectory(file);
      ADD_FAILURE() << "accepted: " << bad.text;
    } catch (const InputError& error) {
      const std::string message = error.what();
      const std::string where = file.string() + ":" + std::to_string(bad.line) + ": ";
      EXPECT_EQ(message.compare(0, where.size(), where), 0) << message;
      EXPECT_NE(message.find(bad.reason), std::string::npos) << message;
      EXPECT_EQ(error.code(), bad.code) << message;
    }
  }
}

TEST(TrajectoryFile, RefusesADeviceThatNeverEnds) {
  imslam::testing::expect_input_error([] { read_trajectory("/dev/zero"); }, ExitCode::kData,
                                      {"not a regular file"});
}

TEST(TrajectoryFile, SaysThatThereAreNoPoses) {
  const TempDir folder;
  for (const char* text : {"", "\n\n", "# only a comment\n"}) {
    EXPECT_THROW(read_trajectory(folder.write("t.tum", text)), InputError);
    EXPECT_THROW(detect_trajectory_format(folder.write("t.tum", text)), InputError);
  }
  EXPECT_THROW(read_trajectory(folder.path() / "absent.tum"), InputError);
  EXPECT_THROW(read_trajectory(folder.path()), InputError);
}

TEST(TrajectoryFile, ReadsBackWhatWasWritten) {
  const TempDir folder;
  const Trajectory trajectory = some_trajectory();
  for (const auto format :
       {TrajectoryFormat::kTum, TrajectoryFormat::kKitti, TrajectoryFormat::kEuroc}) {
    const auto file = folder.path() / "out.txt";
    write_trajectory(file, trajectory, format);
    EXPECT_EQ(detect_trajectory_format(file), format);
    const PosePath path = read_trajectory(file);
    ASSERT_EQ(path.size(), trajectory.size());
    EXPECT_EQ(path.has_stamps(), format != TrajectoryFormat::kKitti);
    EXPECT_EQ(path.frame, format == TrajectoryFormat::kKitti ? "" : "left");
    for (std::size_t i = 0; i < path.size(); ++i) {
      expect_near(path.poses[i].topRightCorner<3, 1>(), trajectory.poses[i].translation(), 0.0);
      expect_near(path.poses[i], trajectory.poses[i].matrix(), 1e-15);
      if (path.has_stamps()) {
        const double exact =
            static_cast<double>(static_cast<long double>(trajectory.times_ns[i]) / 1e9L);
        // EuRoC nanoseconds are read as evo reads them, through a double: 256 ns are lost.
        EXPECT_NEAR(path.stamps_s[i], exact, format == TrajectoryFormat::kTum ? 0.0 : 2.6e-7);
      }
    }
  }
}

TEST(TrajectoryFile, WritesStampsToTheNanosecondAndNoTrailingBlanks) {
  const TempDir folder;
  Trajectory trajectory;
  trajectory.add(1403636579763555584, {});
  trajectory.add(-1'500'000'000, {});
  trajectory.add(7, {});
  const auto file = folder.path() / "out.tum";
  write_trajectory(file, trajectory, TrajectoryFormat::kTum);
  EXPECT_EQ(read_file(file),
            "# time_s tx ty tz qx qy qz qw (T_world_frame) frame: body\n"
            "1403636579.763555584 0 0 0 0 0 0 1\n"
            "-1.500000000 0 0 0 0 0 0 1\n"
            "0.000000007 0 0 0 0 0 0 1\n");
  write_trajectory(file, trajectory, TrajectoryFormat::kKitti);
  EXPECT_EQ(read_file(file).substr(0, 24), "1 0 0 0 0 1 0 0 0 0 1 0\n");
}

TEST(TrajectoryFile, NeverWritesPosesThatAreNotFinite) {
  const TempDir folder;
  Trajectory trajectory;
  trajectory.add(0, lie::SE3d(lie::SO3d(), Eigen::Vector3d(0, std::nan(""), 0)));
  EXPECT_THROW(write_trajectory(folder.path() / "o.tum", trajectory, TrajectoryFormat::kTum),
               ContractError);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "o.tum"));
}

}  // namespace
}  // namespace imslam::datasets
