#include "slam/base/process_group.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "slam/base/packed_strings.hpp"
#include "slam/base/random.hpp"

namespace imslam {
namespace {

/// Runs `body` in `jobs` processes; what it returns on rank 0.
template <typename Body>
auto on_rank_zero(int jobs, const Body& body) {
  ProcessOptions options;
  options.jobs = jobs;
  decltype(body(*single_process())) result;
  run_in_processes(options, [&](ProcessGroup& group) {
    result = body(group);
    return ExitCode::kOk;
  });
  return result;
}

/// Of sizes so different that the order of a sum shows.
std::vector<float> contribution(std::size_t i) {
  Random random(7 + i);
  std::vector<float> values(1000);
  const float size = i % 2 == 0 ? 1e4F : 1e-3F;
  for (float& value : values) value = size * static_cast<float>(random.normal());
  return values;
}

std::vector<float> sum_in(ProcessGroup& group) {
  return ordered_sum(group, 7, 1000, &contribution);
}

TEST(ProcessGroup, ASumHasTheSameBytesForAnyNumberOfProcesses) {
  const auto alone = on_rank_zero(1, &sum_in);
  std::vector<float> expected(1000, 0.0F);
  for (std::size_t i = 0; i < 7; ++i) {
    const auto values = contribution(i);
    for (std::size_t k = 0; k < values.size(); ++k) expected[k] += values[k];
  }
  EXPECT_EQ(alone, expected);
  for (const int jobs : {2, 3, 4, 9}) EXPECT_EQ(on_rank_zero(jobs, &sum_in), alone) << jobs;
}

TEST(ProcessGroup, AllRanksKnowWhatAnyOfThemSays) {
  for (const int speaker : {0, 2, 7}) {
    const auto heard = on_rank_zero(3, [speaker](ProcessGroup& group) {
      return group.gather(group.any(group.rank() == speaker) ? "yes" : "no");
    });
    for (const std::string& word : heard) EXPECT_EQ(word, speaker < 3 ? "yes" : "no") << speaker;
  }
}

TEST(ProcessGroup, EveryRankHasTheSum) {
  const auto seen = on_rank_zero(3, [](ProcessGroup& group) {
    const auto sum = sum_in(group);
    return group.gather(std::string(reinterpret_cast<const char*>(sum.data()), sum.size() * 4));
  });
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen[1], seen[0]);
  EXPECT_EQ(seen[2], seen[0]);
}

TEST(ProcessGroup, ItemsComeBackInTheirOrderEachFromItsOwner) {
  const auto items = on_rank_zero(3, [](ProcessGroup& group) {
    return gather_items(group, 8, [&](std::size_t i) {
      EXPECT_TRUE(group.owns(i));
      return std::to_string(i) + "/" + std::to_string(group.rank());
    });
  });
  const std::vector<std::string> expected = {"0/0", "1/1", "2/2", "3/0",
                                             "4/1", "5/2", "6/0", "7/1"};
  EXPECT_EQ(items, expected);
}

TEST(ProcessGroup, MessagesMayBeLongAndHoldAnyByte) {
  const std::string message = std::string(3 << 20, '\xff') + std::string(5, '\0');
  const auto back = on_rank_zero(2, [&](ProcessGroup& group) {
    const std::string heard = group.broadcast(group.rank() == 0 ? message : "");
    return group.gather(heard);
  });
  EXPECT_EQ(back.at(1), message);
}

TEST(ProcessGroup, AProcessThatDiesIsToldWithItsSignal) {
  try {
    on_rank_zero(3, [](ProcessGroup& group) {
      if (group.rank() == 2) ::kill(::getpid(), SIGKILL);
      return group.gather("");
    });
    FAIL() << "the loss went unnoticed";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kResource);
    EXPECT_NE(std::string(error.what()).find("process 3 of 3"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("signal 9"), std::string::npos) << error.what();
  }
}

TEST(ProcessGroup, AnErrorOfAnotherProcessKeepsItsExitCode) {
  try {
    on_rank_zero(2, [](ProcessGroup& group) {
      if (group.rank() == 1) throw InputError("disk full", ExitCode::kOutput);
      return group.gather("");
    });
    FAIL() << "the error went unnoticed";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kOutput);
  }
}

TEST(ProcessGroup, NoProcessAtAllIsAUsageError) {
  ProcessOptions options;
  options.jobs = 0;
  EXPECT_THROW(run_in_processes(options, [](ProcessGroup&) { return ExitCode::kOk; }), InputError);
}

TEST(ProcessGroup, MpirunOfAProgramBuiltWithoutMpiIsAUsageError) {
  if (built_with_mpi()) GTEST_SKIP() << "built with MPI";
  ::setenv("OMPI_COMM_WORLD_SIZE", "2", 1);
  try {
    run_in_processes(ProcessOptions(), [](ProcessGroup&) { return ExitCode::kOk; });
    ADD_FAILURE() << "every rank would have done all of the work";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    EXPECT_NE(std::string(error.what()).find("--jobs"), std::string::npos) << error.what();
  }
  ::unsetenv("OMPI_COMM_WORLD_SIZE");
}

TEST(PackedStrings, ComeBackAsTheyWere) {
  const std::vector<std::string> strings = {"", std::string(2, '\0'), "abc", std::string(300, 'x')};
  EXPECT_EQ(unpack_strings(pack_strings(strings)), strings);
  EXPECT_THROW(unpack_strings("short"), ContractError);
  EXPECT_THROW(unpack_strings(length_bytes(9) + "cut"), ContractError);
}

}  // namespace
}  // namespace imslam
