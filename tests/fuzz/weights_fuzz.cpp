#include <cstddef>
#include <cstdint>
#include <string>

#include "slam/base/error.hpp"
#include "slam/nn/weights_io.hpp"

/// Any bytes are a weight file or an InputError with the exit code of models, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  try {
    imslam::nn::WeightsFile::parse("fuzz", std::string(reinterpret_cast<const char*>(bytes), size));
  } catch (const imslam::InputError& error) {
    if (error.code() != imslam::ExitCode::kModel) __builtin_trap();
  }
  return 0;
}
