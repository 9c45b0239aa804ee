#include "slam/learner/replay_buffer.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"

namespace imslam::learner {
namespace {

Vector item(double number) { return Vector::Constant(2, number); }

TEST(ReplayBuffer, NeverHoldsMoreThanItsCapacity) {
  ReplayBuffer buffer(10, 1);
  for (int i = 0; i < 100; ++i) buffer.write(item(i));
  EXPECT_EQ(buffer.size(), 10U);
  EXPECT_EQ(buffer.written(), 100U);
}

TEST(ReplayBuffer, KeepsOldAndNewAlike) {
  double sum = 0.0;
  constexpr int kBuffers = 400;
  for (std::uint64_t seed = 0; seed < kBuffers; ++seed) {
    ReplayBuffer buffer(10, seed);
    for (int i = 0; i < 101; ++i) buffer.write(item(i));
    for (const Vector& kept : buffer.read({1, Random(seed)})) sum += kept[0];
  }
  // Uniform over 0 ... 100: mean 50, standard deviation 29.2.
  EXPECT_NEAR(sum / kBuffers, 50.0, 4.0 * 29.2 / std::sqrt(double(kBuffers)));
}

TEST(ReplayBuffer, EqualStreamsDrawEqually) {
  ReplayBuffer buffer(5, 1);
  EXPECT_TRUE(buffer.read({3, Random(1)}).empty());
  for (int i = 0; i < 5; ++i) buffer.write(item(i));
  EXPECT_EQ(buffer.read({8, Random(4)}), buffer.read({8, Random(4)}));
  EXPECT_NE(buffer.read({8, Random(4)}), buffer.read({8, Random(5)}));
}

TEST(ReplayBuffer, SavedAndRestoredItGoesOnBitByBit) {
  ReplayBuffer whole(4, 7);
  ReplayBuffer first(4, 7);
  for (int i = 0; i < 9; ++i) {
    whole.write(item(i));
    first.write(item(i));
  }
  nn::WeightsWriter writer;
  first.save(writer, "memory/");
  ReplayBuffer second(4, 7);
  second.restore(nn::WeightsFile::parse("checkpoint", writer.bytes({})), "memory/");
  for (int i = 9; i < 30; ++i) {
    whole.write(item(i));
    second.write(item(i));
  }
  EXPECT_EQ(whole.read({20, Random(2)}), second.read({20, Random(2)}));
}

TEST(ReplayBuffer, ACheckpointOfAnotherCapacityIsRefused) {
  ReplayBuffer small(2, 1);
  for (int i = 0; i < 5; ++i) small.write(item(i));
  nn::WeightsWriter writer;
  small.save(writer, "memory/");
  ReplayBuffer large(4, 1);
  EXPECT_THROW(large.restore(nn::WeightsFile::parse("checkpoint", writer.bytes({})), "memory/"),
               InputError);
}

}  // namespace
}  // namespace imslam::learner
