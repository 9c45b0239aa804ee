#include "slam/nn/weights_io.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "slam/base/file.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::nn {
namespace {

using imslam::testing::TempDir;

/// A weight file put together by hand.
std::string file_of(const std::string& json, const std::string& data) {
  std::string bytes(8, '\0');
  for (std::size_t i = 0; i < 8; ++i) {
    bytes[i] = static_cast<char>((static_cast<std::uint64_t>(json.size()) >> (8 * i)) & 0xFFU);
  }
  return bytes + json + data;
}

/// The message of the refusal; empty if the file is read.
std::string refusal_of(const std::string& bytes) {
  try {
    WeightsFile::parse("m.safetensors", bytes);
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kModel);
    return error.what();
  }
  return "";
}

const std::string kEight(8, '\0');

TEST(Weights, AHandWrittenFileIsRead) {
  const std::string json =
      R"({"__metadata__":{"made":"by hand"},"b":{"dtype":"F32","shape":[1],"data_offsets":[4,8]},)"
      R"("a":{"dtype":"F16","shape":[2],"data_offsets":[0,4]}})";
  const std::string data("\x00\x3C\x00\xC0\x00\x00\x20\x41", 8);  // 1, -2 as F16; 10 as F32
  const WeightsFile file = WeightsFile::parse("m", file_of(json, data));
  Tensor<float> a({2});
  Tensor<float> b({1});
  file.read_into("a", a);
  file.read_into("b", b);
  EXPECT_EQ(a[0], 1.0F);
  EXPECT_EQ(a[1], -2.0F);
  EXPECT_EQ(b[0], 10.0F);
  EXPECT_EQ(file.metadata().at("made"), "by hand");
  EXPECT_EQ(file.tensors().front().name, "a");
}

TEST(Weights, BrainFloatsAndIntegersAreRead) {
  const std::string json = R"({"n":{"dtype":"I64","shape":[1],"data_offsets":[0,8]},)"
                           R"("w":{"dtype":"BF16","shape":[1],"data_offsets":[8,10]}})";
  const std::string data("\x07\0\0\0\0\0\0\0\x80\x3F", 10);
  const WeightsFile file = WeightsFile::parse("m", file_of(json, data));
  Tensor<double> w({1});
  file.read_into("w", w);
  EXPECT_EQ(file.integer("n"), 7);
  EXPECT_EQ(w[0], 1.0);
}

struct Malformed {
  const char* what;     ///< for people
  std::string bytes;    ///< of the file
  const char* message;  ///< part of the refusal
};

std::vector<Malformed> malformed_headers() {
  const auto one = [](const std::string& fields) {
    return file_of("{\"a\":{" + fields + "}}", kEight);
  };
  const std::string good = R"("dtype":"F32","shape":[2],"data_offsets":[0,8])";
  return {
      {"not JSON", file_of("{\"a\":", kEight), "not JSON"},
      {"a list", file_of("[]", ""), "a list"},
      {"a number", file_of("1", ""), "a number"},
      {"deep", file_of(std::string(100000, '['), ""), "a list"},
      {"deep objects", file_of("{\"a\":{\"b\":{\"c\":{}}}}", ""), "an object"},
      {"two documents", file_of("{} {}", ""), "not JSON"},
      {"null", one(R"("dtype":null)"), "null"},
      {"no dtype", one(R"("shape":[2],"data_offsets":[0,8])"), "lacks"},
      {"no shape", one(R"("dtype":"F32","data_offsets":[0,8])"), "lacks"},
      {"one offset", one(R"("dtype":"F32","shape":[2],"data_offsets":[0])"), "lacks"},
      {"three offsets", one(R"("dtype":"F32","shape":[2],"data_offsets":[0,8,8])"), "too many"},
      {"other dtype", one(R"("dtype":"U8","shape":[8],"data_offsets":[0,8])"), "dtype 'U8'"},
      {"unknown field", one(good + R"(,"x":1)"), "a number"},
      {"same field twice", one(good + R"(,"dtype":"F32")"), "twice"},
      {"shape twice", one(good + R"(,"shape":[2])"), "twice"},
      {"negative size", one(R"("dtype":"F32","shape":[-2],"data_offsets":[0,8])"), "negative"},
      {"fraction", one(R"("dtype":"F32","shape":[2.0],"data_offsets":[0,8])"), "whole"},
      {"huge number", one(R"("dtype":"F32","shape":[99999999999999999999],"data_offsets":[0,8])"),
       "too large"},
      {"six sizes", one(R"("dtype":"F32","shape":[1,1,1,1,1,2],"data_offsets":[0,8])"),
       "at most 5"},
      {"overflowing product",
       one(R"("dtype":"F32","shape":[4294967296,4294967296,4],"data_offsets":[0,8])"), "overflows"},
      {"overflowing bytes",
       one(R"("dtype":"F64","shape":[2305843009213693952],"data_offsets":[0,8])"), "overflows"},
      {"range not of the shape", one(R"("dtype":"F32","shape":[3],"data_offsets":[0,8])"),
       "12 bytes"},
      {"range backwards", one(R"("dtype":"F32","shape":[2],"data_offsets":[8,0])"), "data_offsets"},
      {"metadata not text", file_of(R"({"__metadata__":{"a":1}})", ""), "a number"},
      {"metadata key twice", file_of(R"({"__metadata__":{"a":"1","a":"2"}})", ""), "twice"},
      {"metadata twice", file_of(R"({"__metadata__":{},"__metadata__":{}})", ""), "twice"},
      {"long text", file_of("{\"__metadata__\":{\"a\":\"" + std::string(20000, 'a') + "\"}}", ""),
       "above 16 kB"},
      {"long number", file_of("{\"a\":" + std::string(20000, '1') + "}", ""), "above 16 kB"},
      {"empty name", file_of("{\"\":{" + good + "}}", kEight), "length 0"},
  };
}

std::vector<Malformed> malformed_layouts() {
  const auto two = [](const std::string& first, const std::string& second,
                      const std::string& data) {
    return file_of("{\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":" + first +
                       "},\"b\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":" + second + "}}",
                   data);
  };
  const std::string one_nan = file_of(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}})",
                                      std::string("\x00\x00\xC0\x7F", 4));
  const std::string half_infinity = file_of(
      R"({"a":{"dtype":"F16","shape":[1],"data_offsets":[0,2]}})", std::string("\x00\x7C", 2));
  const std::string wrong_hash =
      file_of(R"({"__metadata__":{"card.sha256":"00"},"a":{"dtype":"F32","shape":[1],)"
              R"("data_offsets":[0,4]}})",
              std::string(4, '\0'));
  return {
      {"empty file", "", "shorter than 8"},
      {"seven bytes", std::string(7, '\0'), "shorter than 8"},
      {"no header", kEight, "not JSON"},
      {"header longer than the file", std::string("\x40\0\0\0\0\0\0\0{}", 10),
       "64 bytes is stated"},
      {"header of 2^64-1", std::string(8, '\xFF') + "{}", "is stated"},
      {"overlap", two("[0,4]", "[0,4]", std::string(4, '\0')), "overlap"},
      {"partial overlap", two("[0,4]", "[2,6]", std::string(8, '\0')), "overlap"},
      {"gap", two("[0,4]", "[8,12]", std::string(12, '\0')), "gap"},
      {"gap in front", two("[4,8]", "[8,12]", std::string(12, '\0')), "gap"},
      {"bytes left over", two("[0,4]", "[4,8]", std::string(9, '\0')), "the file at 9"},
      {"data too short", two("[0,4]", "[4,8]", std::string(7, '\0')), "the file at 7"},
      {"same name twice",
       file_of(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]},)"
               R"("a":{"dtype":"F32","shape":[1],"data_offsets":[4,8]}})",
               kEight),
       "twice"},
      {"NaN", one_nan, "not finite"},
      {"infinite half", half_infinity, "not finite"},
      {"other numbers than the hash", wrong_hash, "sha256"},
  };
}

TEST(Weights, MalformedFilesAreRefusedWithTheReason) {
  std::vector<Malformed> table = malformed_headers();
  for (Malformed& more : malformed_layouts()) table.push_back(std::move(more));
  for (const Malformed& bad : table) {
    const std::string message = refusal_of(bad.bytes);
    EXPECT_NE(message.find(bad.message), std::string::npos) << bad.what << ": '" << message << "'";
    EXPECT_NE(message.find("m.safetensors: "), std::string::npos) << bad.what;
  }
}

std::string small_file() {
  WeightsWriter writer;
  writer.add("layer.weight", Tensor<float>({2, 3}, {1, 2, 3, 4, 5, 6}));
  writer.add("layer.bias", Tensor<float>({3}, {0.5F, -0.5F, 0.25F}), NumberType::kF16);
  Metadata metadata;
  put_card({"a test", "none", "gtest", "7", "", "all", "", ""}, metadata);
  return writer.bytes(metadata);
}

TEST(Weights, EveryPrefixAndEveryFlippedBitOfTheHeaderIsHandled) {
  const std::string good = small_file();
  ASSERT_EQ(refusal_of(good), "");
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_NE(refusal_of(good.substr(0, length)), "") << length;
  }
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      std::string bad = good;
      bad[at] = static_cast<char>(static_cast<unsigned char>(bad[at]) ^ (1U << bit));
      refusal_of(bad);  // read or refused with exit code 5, never anything else
    }
  }
  std::string other_number = good;
  other_number.back() = static_cast<char>(other_number.back() ^ 1);
  EXPECT_NE(refusal_of(other_number).find("sha256"), std::string::npos);
}

TEST(Weights, WritingIsDeterministicAndReadsBackBitByBit) {
  EXPECT_EQ(small_file(), small_file());
  const WeightsFile file = WeightsFile::parse("m", small_file());
  Tensor<float> weight({2, 3});
  Tensor<float> bias({3});
  file.read_into("layer.weight", weight);
  file.read_into("layer.bias", bias);
  EXPECT_EQ(weight[5], 6.0F);
  EXPECT_EQ(bias[1], -0.5F);
  EXPECT_EQ(file.card().seed, "7");
  EXPECT_EQ(file.card().sha256, file.data_sha256());
  EXPECT_NE(card_markdown(file.card()).find("**Limits:** all"), std::string::npos);
  EXPECT_NE(card_markdown(file.card()).find("**Metrics:** not stated"), std::string::npos);
}

TEST(Weights, NumbersThatAreNotFiniteAreNotWritten) {
  WeightsWriter writer;
  const Tensor<float> nan({1}, {std::nanf("")});
  const Tensor<float> large({1}, {1e6F});
  EXPECT_THROW(writer.add("a", nan), InputError);
  EXPECT_THROW(writer.add("b", large, NumberType::kF16), InputError);
  EXPECT_NO_THROW(writer.add("c", large));
  EXPECT_THROW(writer.add("c", large), ContractError);
}

struct TwoParameters {
  TwoParameters() : weight({2, 3}), bias(Shape{3}) {
    list.add("layer.weight", weight);
    list.add("layer.bias", bias);
  }
  Parameter<float> weight;
  Parameter<float> bias;
  ParameterList<float> list;
};

TEST(Weights, ParametersAreSavedAndLoaded) {
  const TempDir dir;
  TwoParameters saved;
  saved.weight.value[4] = 0.1F;
  saved.bias.value[0] = -3.0F;
  const auto path = dir.path() / "m.safetensors";
  save_parameters(path, saved.list, {});
  TwoParameters loaded;
  load_parameters(WeightsFile::read(path), loaded.list);
  EXPECT_TRUE((loaded.weight.value.array() == saved.weight.value.array()).all());
  EXPECT_TRUE((loaded.bias.value.array() == saved.bias.value.array()).all());
}

TEST(Weights, TheWeightsOfAnotherNetworkAreRefusedByName) {
  WeightsWriter writer;
  writer.add("layer.weight", Tensor<float>({3, 2}));
  writer.add("head.weight", Tensor<float>({1}));
  const WeightsFile file = WeightsFile::parse("m", writer.bytes({}));
  TwoParameters network;
  try {
    load_parameters(file, network.list);
    FAIL() << "expected an InputError";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.code(), ExitCode::kModel);
    EXPECT_NE(message.find("missing tensors: layer.bias"), std::string::npos) << message;
    EXPECT_NE(message.find("unknown tensors: head.weight"), std::string::npos) << message;
    EXPECT_NE(message.find("layer.weight [3,2] instead of [2,3]"), std::string::npos) << message;
  }
}

TEST(Weights, MissingFilesFoldersAndDevicesAreRefused) {
  const TempDir dir;
  for (const std::string& path :
       {dir.path().string() + "/none", dir.path().string(), std::string("/dev/zero")}) {
    try {
      WeightsFile::read(path);
      FAIL() << path;
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kModel) << path;
    }
  }
}

}  // namespace
}  // namespace imslam::nn
