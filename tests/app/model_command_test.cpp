#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "slam/base/file.hpp"
#include "tests/support/command.hpp"

namespace imslam {
namespace {

using testing::quoted;
using testing::run_imslam;
using testing::TempDir;

const std::string kNumbers("\0\0\x80\x3F\0\0\0\x40", 8);  // 1, 2 as F32

/// A weight file of two numbers; `metadata` as JSON.
std::string weights(const std::string& metadata, const std::string& data = kNumbers) {
  const std::string json = "{\"__metadata__\":" + metadata +
                           ",\"layer.weight\":{\"dtype\":\"F32\",\"shape\":[2],"
                           "\"data_offsets\":[0,8]}}";
  std::string length(8, '\0');
  length[0] = static_cast<char>(json.size() & 0xFFU);
  length[1] = static_cast<char>(json.size() >> 8U);
  return length + json + data;
}

std::string with_hash() {
  return "{\"card.what\":\"two numbers\",\"card.sha256\":\"" + sha256(kNumbers) + "\"}";
}

TEST(ModelCommand, ShowsTheCardAndTheTensors) {
  const TempDir dir;
  const auto file = dir.write("m.safetensors", weights(with_hash()));
  const auto text = run_imslam(dir, "model info " + quoted(file.string()));
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("**What:** two numbers"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("layer.weight  F32  [2]"), std::string::npos) << text.out;
  const auto shown = run_imslam(dir, "model info --json " + quoted(file.string()));
  const auto json = nlohmann::json::parse(shown.out);
  EXPECT_EQ(json["numbers"], 2);
  EXPECT_EQ(json["data_sha256"], sha256(kNumbers));
  EXPECT_EQ(json["tensors"][0]["shape"][0], 2);
}

TEST(ModelCommand, VerifiesTheHash) {
  const TempDir dir;
  const auto good = dir.write("good.safetensors", weights(with_hash()));
  EXPECT_EQ(run_imslam(dir, "model verify " + quoted(good.string())).exit_code, 0);
  std::string other = kNumbers;
  other[0] = 1;
  const auto changed = dir.write("changed.safetensors", weights(with_hash(), other));
  EXPECT_EQ(run_imslam(dir, "model verify " + quoted(changed.string())).exit_code, 5);
  const auto unsigned_file = dir.write("unsigned.safetensors", weights("{}"));
  EXPECT_EQ(run_imslam(dir, "model verify " + quoted(unsigned_file.string())).exit_code, 5);
}

TEST(ModelCommand, RefusesWhatIsNoWeightFile) {
  const TempDir dir;
  const auto text = dir.write("m.safetensors", "not a weight file at all");
  const auto result = run_imslam(dir, "model info " + quoted(text.string()));
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_NE(result.err.find("m.safetensors"), std::string::npos) << result.err;
  EXPECT_EQ(run_imslam(dir, "model info " + quoted((dir.path() / "none").string())).exit_code, 5);
  EXPECT_EQ(run_imslam(dir, "model").exit_code, 2);
}

}  // namespace
}  // namespace imslam
