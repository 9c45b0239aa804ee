// `imslam run` that is stopped, or cannot write; ../shared/reference/reliability.md, D4, D6, D7.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "tests/support/run_check.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using testing::quoted;
using testing::run_imslam;
using testing::slurp;
using testing::TempDir;

constexpr const char* kShort = "--frames 0:30";

/// Starts `imslam run` without waiting for it.
pid_t start_run(const std::string& dataset, const fs::path& out, const std::string& frames) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_DFL);
  ::close(STDOUT_FILENO);
  ::open("/dev/null", O_WRONLY);
  ::execl(IMSLAM_EXECUTABLE, "imslam", "--quiet", "run", dataset.c_str(), "--out", out.c_str(),
          "--frames", frames.c_str(), static_cast<char*>(nullptr));
  ::_exit(127);
}

/// Its exit code; minus the signal that ended it.
int wait_for(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

class StartedRun : public ::testing::Test {
 protected:
  /// Runs, and sends `signal` `delay_s` after the run folder has appeared.
  int interrupted_run(const fs::path& out, int signal, double delay_s) {
    const pid_t child = start_run(base_.string(), out, ":");
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!fs::exists(out) && std::chrono::steady_clock::now() < deadline) ::usleep(10'000);
    std::this_thread::sleep_for(std::chrono::duration<double>(delay_s));
    ::kill(child, signal);
    return wait_for(child);
  }
  testing::CommandResult run(const std::string& arguments, const std::string& before = "") {
    return run_imslam(dir_, "run " + quoted(base_.string()) + " " + kShort + " " + arguments,
                      before);
  }

  TempDir dir_;
  fs::path base_ = testing::simulated_base().sequence;
};

class Interruption : public StartedRun {};
class Output : public StartedRun {};

TEST_F(Interruption, LeavesAValidFolderAndTheCodeOfItsSignal) {  // D6
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const fs::path out = dir_.path() / std::to_string(signal);
    EXPECT_EQ(interrupted_run(out, signal, 0.3), 128 + signal);
    testing::CheckedRun part;
    testing::expect_complete_run(out, part);
    EXPECT_GE(part.metrics.at("frames").get<int>(), 2);
    EXPECT_LT(part.metrics.at("frames").get<int>(), 121);
    EXPECT_TRUE(part.metrics.at("stopped").get<bool>());
    EXPECT_NE(part.metrics.at("warnings").dump().find("of 121 frames"), std::string::npos);
    EXPECT_NE(slurp(out / "report.html").find("stopped after"), std::string::npos);
  }
}

TEST_F(Interruption, BeforeTheFirstMotionIsClean) {  // D6
  for (const double delay_s : {0.0, 0.01, 0.03, 0.1}) {
    const fs::path out = dir_.path() / std::to_string(delay_s);
    EXPECT_EQ(interrupted_run(out, SIGTERM, delay_s), 128 + SIGTERM) << delay_s;
    const std::string poses = slurp(out / "trajectory.tum");
    if (!poses.empty()) testing::expect_poses(poses);
  }
}

TEST_F(Interruption, OfARenderingHasTheCodeOfItsSignal) {  // D6
  for (const char* signal : {"INT", "TERM"}) {
    const auto result =
        run_imslam(dir_, "simulate " + quoted((dir_.path() / signal).string()) + " --quiet",
                   std::string("timeout --preserve-status -s ") + signal + " 0.7");
    EXPECT_EQ(result.exit_code, signal == std::string("INT") ? 130 : 143);
  }
}

TEST_F(Output, ThatCannotBeWrittenIsCodeSix) {  // D4
  for (const char* place : {"/proc/run", "/dev/null/run", "/sys/kernel/run"}) {
    const auto result = run(std::string("--out ") + place);
    EXPECT_EQ(result.exit_code, 6) << place << result.err;
  }
}

TEST_F(Output, FilesThatMayNotGrowAreCodeSix) {  // D4: not beyond 8 kB
  const fs::path out = dir_.path() / "run";
  const auto result = run("--out " + quoted(out.string()), "trap '' XFSZ; ulimit -f 8;");
  EXPECT_EQ(result.exit_code, 6) << result.err;
  for (const auto& entry : fs::directory_iterator(out)) {
    EXPECT_EQ(entry.path().string().find("tmp"), std::string::npos) << entry.path();
  }
}

/// Needs a mount of its own: a user namespace, or root.
TEST_F(Output, AFullDiskIsCodeSixAndLeavesEarlierRunsAlone) {  // D4
  const std::string unshare =
      std::system("unshare -m true 2>/dev/null") == 0 ? "unshare -m" : "unshare -Urm";
  if (std::system((unshare + " mount -t tmpfs tmpfs /mnt 2>/dev/null").c_str()) != 0) {
    GTEST_SKIP() << "no right to mount";
  }
  dir_.write("runs/earlier/manifest.json", "{}");
  dir_.write("runs/earlier/trajectory.tum", "0 0 0 0 0 0 0 1\n");
  fs::create_directory_symlink("earlier", dir_.path() / "runs" / "latest");
  fs::create_directory(dir_.path() / "disk");
  for (const std::string place : {"--runs runs", "--force --out runs/earlier"}) {
    dir_.write(
        "full.sh",
        "mount -t tmpfs -o size=128k tmpfs disk && cp -a runs disk && cd disk || exit 99\n"
        "\"$@\" " +
            place +
            "\ncode=$?\n"
            "diff -r runs/earlier ../runs/earlier && [ \"$(readlink runs/latest)\" = earlier ]"
            " || exit 98\n"
            "[ -z \"$(ls -A runs | grep '^\\.')\" ] || exit 97\nexit $code\n");
    const auto result =
        run_imslam(dir_, "run " + quoted(fs::absolute(base_).string()) + " --quiet " + kShort,
                   "cd " + quoted(dir_.path().string()) + " && " + unshare + " sh full.sh");
    EXPECT_EQ(result.exit_code, 6) << place << "\n" << result.out << result.err;
    EXPECT_NE(result.err.find("free space"), std::string::npos) << result.err;
  }
}

TEST_F(Output, OfTwoRunsIntoOnePlaceOneIsRefused) {  // D7
  const fs::path out = dir_.path() / "run";
  const pid_t first = start_run(base_.string(), out, "0:60");
  const pid_t second = start_run(base_.string(), out, "0:60");
  const int codes[] = {wait_for(first), wait_for(second)};
  EXPECT_EQ(std::min(codes[0], codes[1]), 0);
  EXPECT_EQ(std::max(codes[0], codes[1]), 6);
  testing::CheckedRun run;
  testing::expect_complete_run(out, run);
  EXPECT_EQ(run.metrics.at("frames").get<int>(), 60);
}

}  // namespace
}  // namespace imslam
