#include "slam/adaptation/adaptation_options.hpp"

#include <gtest/gtest.h>

#include <string>

#include "slam/base/error.hpp"

namespace imslam::adaptation {
namespace {

std::string refusal_of(const AdaptationOptions& options) {
  try {
    options.validate();
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    return error.what();
  }
  return "none";
}

TEST(AdaptationOptions, NameTheKeyAsItIsGiven) {
  EXPECT_EQ(refusal_of({}), "none");
  AdaptationOptions options;
  options.rate = 2.0;
  EXPECT_NE(refusal_of(options).find("finetune.rate"), std::string::npos) << refusal_of(options);
  options = {};
  options.patience = -1;
  EXPECT_NE(refusal_of(options).find("finetune.patience"), std::string::npos)
      << refusal_of(options);
}

// Of ten stretches at a fifth, the third and the eighth.
TEST(AdaptationOptions, HoldOutTheStretchInTheMiddleOfEachCycle) {
  AdaptationOptions options;
  options.held_out = 0.2;
  options.stretch = 3;
  for (std::size_t frame = 0; frame < 30; ++frame) {
    EXPECT_EQ(is_held_out(frame, options), frame / 3 == 2 || frame / 3 == 7) << frame;
  }
}

}  // namespace
}  // namespace imslam::adaptation
