// `imslam finetune` that is stopped, killed, started twice, or cannot write.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include "slam/base/random.hpp"
#include "tests/support/finetune_check.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using testing::expect_same_weights;
using testing::finetune;
using testing::quoted;
using testing::slurp;
using testing::TempDir;

/// Stops a fine-tuning after `delay_s` with `signal`, unless it has ended before.
testing::CommandResult stopped(const TempDir& dir, const std::string& signal, double delay_s) {
  return finetune(dir, "stopped", "--resume --quiet",
                  "timeout -s " + signal + " " + std::to_string(delay_s));
}

TEST(FinetuneInterruption, KilledAtRandomMomentsItEndsInTheSameBytes) {
  const TempDir dir;
  ASSERT_EQ(finetune(dir, "whole").exit_code, 0);
  Random random(7);
  for (int kill = 0; kill < 5; ++kill) {
    const double delay_s = random.uniform(0.1, 4.0);
    if (stopped(dir, "KILL", delay_s).exit_code == 0) break;
  }
  const auto last = finetune(dir, "stopped", "--resume");
  ASSERT_EQ(last.exit_code, 0) << last.err;
  expect_same_weights(dir.path() / "whole" / "tuned", dir.path() / "stopped" / "tuned");
}

TEST(FinetuneInterruption, MatchesThatAreAskedForOnceAreTheSameAfterAStop) {
  const TempDir dir;
  const std::string frozen = "--set finetune.matcher=off ";
  ASSERT_EQ(finetune(dir, "whole", frozen).exit_code, 0);
  for (const double delay_s : {1.0, 1.6, 2.4}) {
    const auto result = finetune(dir, "stopped", frozen + "--resume --quiet",
                                 "timeout -s KILL " + std::to_string(delay_s));
    if (result.exit_code == 0) break;
  }
  ASSERT_EQ(finetune(dir, "stopped", frozen + "--resume").exit_code, 0);
  testing::expect_same_files(dir.path() / "whole" / "tuned", dir.path() / "stopped" / "tuned",
                             testing::kLearnedFiles);
}

TEST(FinetuneInterruption, StoppedInGoodOrderItEndsInTheSameBytes) {
  const TempDir dir;
  ASSERT_EQ(finetune(dir, "whole").exit_code, 0);
  const int code = stopped(dir, "TERM", 2.0).exit_code;  // of timeout, or of a fast machine
  EXPECT_TRUE(code == 124 || code == 0) << code;
  ASSERT_EQ(finetune(dir, "stopped", "--resume").exit_code, 0);
  expect_same_weights(dir.path() / "whole" / "tuned", dir.path() / "stopped" / "tuned");
}

TEST(FinetuneInterruption, GoesOnOnlyWithTheSameOptionsAndData) {
  const TempDir dir;
  ASSERT_EQ(finetune(dir, ".").exit_code, 0);
  const fs::path folder = dir.path() / "tuned";
  const auto all = [&] {
    std::string bytes;
    for (const char* name : {"before.safetensors", "networks.safetensors", "checkpoint.safetensors",
                             "config.yaml", "log.csv", "metrics.json"}) {
      bytes += slurp(folder / name);
    }
    return bytes;
  };
  const std::string before = all();
  const auto in_use = finetune(dir, ".");
  EXPECT_EQ(in_use.exit_code, 6);
  EXPECT_NE(in_use.err.find("--overwrite"), std::string::npos) << in_use.err;
  EXPECT_EQ(finetune(dir, ".", "--resume --set finetune.rate=0.01").exit_code, 5);
  EXPECT_EQ(finetune(dir, ".", "--resume --set finetune.seed=2").exit_code, 5);
  EXPECT_EQ(finetune(dir, ".", "--overwrite --networks tuned/weights").exit_code, 2);
  const auto other = testing::simulated_base().recordings[1].sequence;
  EXPECT_EQ(testing::run_imslam(dir, "finetune " + quoted(other.string()) + testing::kTinyFinetune +
                                         "--resume --out " + quoted(folder.string()))
                .exit_code,
            5);
  EXPECT_EQ(all(), before);
}

TEST(FinetuneInterruption, WhileAnotherProcessHoldsTheFolderItIsRefused) {
  const TempDir dir;
  fs::create_directories(dir.path() / "tuned");
  const int folder = ::open((dir.path() / "tuned").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(folder, LOCK_EX | LOCK_NB), 0);
  EXPECT_EQ(finetune(dir, ".").exit_code, 6);
  EXPECT_TRUE(fs::is_empty(dir.path() / "tuned"));
  ::close(folder);
}

/// Needs a mount of its own: a user namespace, or root.
TEST(FinetuneInterruption, AFullDiskIsCodeSixAndLeavesTheOldWeightsAlone) {
  const TempDir dir;
  const std::string unshare =
      std::system("unshare -m true 2>/dev/null") == 0 ? "unshare -m" : "unshare -Urm";
  if (std::system((unshare + " mount -t tmpfs tmpfs /mnt 2>/dev/null").c_str()) != 0) {
    GTEST_SKIP() << "no right to mount";
  }
  ASSERT_EQ(finetune(dir, ".").exit_code, 0);
  fs::remove_all(dir.path() / "tuned" / "zero_shot");
  fs::remove_all(dir.path() / "tuned" / "adapted");
  fs::create_directory(dir.path() / "disk");
  // Room for a small file, not for another checkpoint.
  dir.write("full.sh",
            "size=$(($(du -sk tuned | cut -f1) + 1024))\n"
            "mount -t tmpfs -o size=${size}k tmpfs disk && cp -a tuned disk && cd disk || exit 99\n"
            "\"$@\"\ncode=$?\n"
            "for name in before networks checkpoint weights/match_network weights/motion_noise "
            "weights/imu_network; do\n"
            "  cmp tuned/$name.safetensors ../tuned/$name.safetensors || exit 98\ndone\n"
            "[ -z \"$(ls -A tuned | grep '^\\.')\" ] || exit 97\nexit $code\n");
  const auto result = finetune(dir, ".", "--resume", unshare + " sh full.sh");
  EXPECT_EQ(result.exit_code, 6) << result.out << result.err;
  EXPECT_NE(result.err.find("free space"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace imslam
