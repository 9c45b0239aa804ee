#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "slam/base/error.hpp"

namespace imslam::testing {

/// Runs `action`, which has to throw InputError with this code and all these words in its message.
template <typename Action>
void expect_input_error(const Action& action,
                        ExitCode code,
                        const std::vector<std::string>& words = {}) {
  try {
    action();
    ADD_FAILURE() << "expected an InputError";
  } catch (const InputError& error) {
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code)) << error.what();
    for (const std::string& word : words) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos)
          << "no \"" << word << "\" in: " << error.what();
    }
  }
}

}  // namespace imslam::testing
