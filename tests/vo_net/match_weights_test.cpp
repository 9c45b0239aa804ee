#include "vo_net/match_weights.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/vo_net/match_fixture.hpp"

namespace imslam::vo {
namespace {

using testing::TempDir;

ExitCode code_of(const std::string& file) {
  try {
    load_match_network(file);
  } catch (const InputError& error) {
    return error.code();
  }
  return ExitCode::kOk;
}

TEST(MatchWeights, AreReadBackWithTheirCard) {
  const TempDir dir;
  const std::string file = (dir.path() / "net.safetensors").string();
  Random random(5);
  MatchNetwork<float> network({}, random);
  testing::shake(testing::parameters_of(network), random, 0.05);
  nn::ModelCard card;
  card.what = "a test";
  nn::save_parameters(file, testing::parameters_of(network), card);

  const TrainedMatchNetwork read = load_match_network(file);
  EXPECT_EQ(read.file, file);
  EXPECT_EQ(read.card.what, "a test");
  EXPECT_EQ(read.card.sha256.size(), 64U);
  network.fold();
  EXPECT_TRUE((read.network->encoder.quarter.block.conv.weight.value.array() ==
               network.encoder.quarter.block.conv.weight.value.array())
                  .all());
  EXPECT_TRUE((read.network->stereo.head.output.weight.value.array() ==
               network.stereo.head.output.weight.value.array())
                  .all());
}

TEST(MatchWeights, OtherFilesAreRefusedAsModels) {
  const TempDir dir;
  EXPECT_EQ(code_of((dir.path() / "absent.safetensors").string()), ExitCode::kModel);
  const std::string text = (dir.path() / "text").string();
  write_file_atomic(text, "no weights at all");
  EXPECT_EQ(code_of(text), ExitCode::kModel);
  const std::string tiny = (dir.path() / "tiny").string();
  Random random(5);
  MatchNetwork<float> network(testing::tiny_match_network(), random);
  nn::save_parameters(tiny, testing::parameters_of(network), {});
  EXPECT_EQ(code_of(tiny), ExitCode::kModel);
}

TEST(MatchWeights, TheShippedOnesAreWholeOrMissing) {
  EXPECT_EQ(code_of(""), shipped_match_weights() ? ExitCode::kOk : ExitCode::kModel);
}

}  // namespace
}  // namespace imslam::vo
