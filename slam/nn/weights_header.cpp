#include "slam/nn/weights_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>

#include "slam/base/error.hpp"

namespace imslam::nn {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostTensors = 16384;
constexpr std::size_t kLongestName = 256;
constexpr std::size_t kLongestText = 16384;
constexpr std::uint64_t kLargestSize = std::uint64_t{1} << 62U;
constexpr const char* kMetadataKey = "__metadata__";

struct TypeName {
  NumberType type;
  const char* name;
  std::size_t bytes;
};
constexpr std::array<TypeName, 5> kTypes{{{NumberType::kF16, "F16", 2},
                                          {NumberType::kBF16, "BF16", 2},
                                          {NumberType::kF32, "F32", 4},
                                          {NumberType::kF64, "F64", 8},
                                          {NumberType::kI64, "I64", 8}}};

const TypeName& row_of(NumberType type) {
  return *std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& t) { return t.type == type; });
}

/// A tensor as far as it has been read.
struct OpenTensor {
  std::string name;
  std::string type;
  std::vector<std::uint64_t> shape;
  std::vector<std::uint64_t> offsets;
  bool has_type = false;
  bool has_shape = false;
  bool has_offsets = false;
};

/// Follows the JSON token by token and stops at the first that does not belong there.
class HeaderReader : public nlohmann::json_sax<Json> {
 public:
  explicit HeaderReader(WeightsHeader& header) : header_(header) {}

  const std::string& problem() const { return problem_; }

  bool null() override { return refuse("null"); }
  bool boolean(bool) override { return refuse("true or false"); }
  bool number_integer(number_integer_t) override { return refuse("a negative number"); }
  bool number_float(number_float_t, const string_t&) override {
    return refuse("a number that is not whole or too large");
  }
  bool binary(binary_t&) override { return refuse("binary data"); }

  bool number_unsigned(number_unsigned_t number) override {
    if (list_ == nullptr) return refuse("a number");
    if (list_->size() >= (list_ == &tensor_.offsets ? 2U : std::size_t{Shape::kMaxRank})) {
      return refuse("too many numbers (at most 5 sizes, 2 offsets)");
    }
    list_->push_back(number);
    return true;
  }

  bool string(string_t& text) override {
    if (place_ == Place::kMetadata) return add_metadata(text);
    if (place_ == Place::kTensor && field_ == "dtype") {
      tensor_.type = text.substr(0, 16);
      return once(tensor_.has_type);
    }
    return refuse("a text");
  }

  bool start_object(std::size_t) override {
    if (place_ == Place::kStart) return enter(Place::kTop);
    if (place_ != Place::kTop || list_ != nullptr) return refuse("an object");
    if (field_ == kMetadataKey) return once(has_metadata_) && enter(Place::kMetadata);
    if (header_.tensors.size() >= kMostTensors) return refuse("more than 16384 tensors");
    tensor_ = OpenTensor();
    tensor_.name = field_;
    return enter(Place::kTensor);
  }

  bool key(string_t& text) override {
    if (text.empty() || text.size() > kLongestName) return refuse("a key of length 0 or above 256");
    field_ = text;
    return true;
  }

  bool end_object() override {
    if (place_ == Place::kTop) return enter(Place::kEnd);
    if (place_ == Place::kTensor && !close_tensor()) return false;
    return enter(Place::kTop);
  }

  bool start_array(std::size_t) override {
    if (place_ != Place::kTensor || list_ != nullptr) return refuse("a list");
    if (field_ == "shape") {
      list_ = &tensor_.shape;
      return once(tensor_.has_shape);
    }
    if (field_ == "data_offsets") {
      list_ = &tensor_.offsets;
      return once(tensor_.has_offsets);
    }
    return refuse("a list");
  }

  bool end_array() override {
    list_ = nullptr;
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const Json::exception&) override {
    problem_ = fmt::format("the header is not JSON (byte {})", position);
    return false;
  }

 private:
  enum class Place { kStart, kTop, kMetadata, kTensor, kEnd };

  bool enter(Place place) {
    place_ = place;
    return true;
  }

  bool fail(const std::string& what) {
    problem_ = what;
    return false;
  }
  bool refuse(const char* what) {
    return fail(
        fmt::format("the header holds {} at key '{}', which does not belong there", what, field_));
  }

  bool once(bool& seen) {
    if (seen) return fail(fmt::format("key '{}' stands twice", field_));
    seen = true;
    return true;
  }

  bool add_metadata(const std::string& text) {
    if (header_.metadata.emplace(field_, text).second) return true;
    return fail(fmt::format("metadata '{}' stands twice", field_));
  }

  bool close_tensor() {
    const auto& t = tensor_;
    if (!t.has_type || !t.has_shape || t.offsets.size() != 2) {
      return fail(fmt::format("tensor '{}' lacks dtype, shape or data_offsets", t.name));
    }
    const auto type = std::find_if(kTypes.begin(), kTypes.end(),
                                   [&](const TypeName& known) { return known.name == t.type; });
    if (type == kTypes.end()) {
      return fail(fmt::format("tensor '{}' has dtype '{}'; F16, BF16, F32, F64, I64 are read",
                              t.name, t.type));
    }
    std::uint64_t size = 1;
    std::array<Index, Shape::kMaxRank> sizes{};
    for (std::size_t i = 0; i < t.shape.size(); ++i) {
      const std::uint64_t n = t.shape[i];
      if (n > kLargestSize || (n > 0 && size > kLargestSize / type->bytes / n)) {
        return fail(fmt::format("tensor '{}': the product of its sizes overflows", t.name));
      }
      size *= n;
      sizes[i] = static_cast<Index>(n);
    }
    if (t.offsets[1] < t.offsets[0] || t.offsets[1] - t.offsets[0] != size * type->bytes) {
      return fail(
          fmt::format("tensor '{}': data_offsets [{}, {}] are not the {} bytes of its shape",
                      t.name, t.offsets[0], t.offsets[1], size * type->bytes));
    }
    const Shape shape(sizes.data(), static_cast<int>(t.shape.size()));
    header_.tensors.push_back({t.name, type->type, shape, t.offsets[0], t.offsets[1]});
    return true;
  }

  WeightsHeader& header_;
  Place place_ = Place::kStart;
  bool has_metadata_ = false;
  std::string field_;
  OpenTensor tensor_;
  std::vector<std::uint64_t>* list_ = nullptr;
  std::string problem_;
};

void expect_unique_names(const std::string& file, const std::vector<TensorEntry>& tensors) {
  std::vector<std::string_view> names;
  names.reserve(tensors.size());
  for (const TensorEntry& tensor : tensors) names.push_back(tensor.name);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice != names.end()) fail_model(file, fmt::format("tensor '{}' stands twice", *twice));
}

/// Whether a text, number or word of the JSON is longer than what a JSON reader should be asked to
/// hold: it keeps several copies of the one that it is at.
bool has_long_token(std::string_view json) {
  std::size_t length = 0;
  bool in_text = false;
  bool escaped = false;
  for (const char c : json) {
    const bool quote = c == '"' && !escaped;
    escaped = in_text && c == '\\' && !escaped;
    if (quote) in_text = !in_text;
    const bool between = !in_text && std::strchr(" \t\r\n,:[]{}", c) != nullptr;
    length = quote || between ? 0 : length + 1;
    if (length > kLongestText) return true;
  }
  return false;
}

/// Ranges must follow one another from 0 to the end of the data.
void expect_tiling(const std::string& file,
                   const std::vector<TensorEntry>& tensors,
                   std::uint64_t data_bytes) {
  std::uint64_t end = 0;
  for (const TensorEntry& tensor : tensors) {
    if (tensor.begin != end) {
      fail_model(file, fmt::format("tensor '{}' starts at byte {} of the data, expected {} ({})",
                                   tensor.name, tensor.begin, end,
                                   tensor.begin < end ? "overlap" : "gap"));
    }
    end = tensor.end;
  }
  if (end != data_bytes) {
    fail_model(file, fmt::format("the tensors end at byte {} of the data, the file at {}", end,
                                 data_bytes));
  }
}

}  // namespace

const char* name_of(NumberType type) { return row_of(type).name; }

std::size_t bytes_of(NumberType type) { return row_of(type).bytes; }

void fail_model(const std::string& file, const std::string& what) {
  throw InputError(file + ": " + what + "; expected a safetensors weight file of this program",
                   ExitCode::kModel);
}

WeightsHeader parse_weights_header(const std::string& file,
                                   std::string_view json,
                                   std::uint64_t data_bytes) {
  if (has_long_token(json)) fail_model(file, "the header holds a text above 16 kB");
  WeightsHeader header;
  HeaderReader reader(header);
  if (!Json::sax_parse(json.begin(), json.end(), &reader)) fail_model(file, reader.problem());
  expect_unique_names(file, header.tensors);
  std::stable_sort(header.tensors.begin(), header.tensors.end(), [](const auto& a, const auto& b) {
    return a.begin != b.begin ? a.begin < b.begin : a.end < b.end;  // empty ones first
  });
  expect_tiling(file, header.tensors, data_bytes);
  return header;
}

std::string print_weights_header(const WeightsHeader& header) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  if (!header.metadata.empty()) json[kMetadataKey] = header.metadata;
  for (const TensorEntry& tensor : header.tensors) {
    auto shape = nlohmann::ordered_json::array();
    for (int axis = 0; axis < tensor.shape.rank(); ++axis) shape.push_back(tensor.shape[axis]);
    json[tensor.name] = {{"dtype", name_of(tensor.type)},
                         {"shape", shape},
                         {"data_offsets", {tensor.begin, tensor.end}}};
  }
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
  std::string text = json.dump(-1, ' ', false, kReplace);
  expects(!has_long_token(text), "print_weights_header: metadata texts of at most 16 kB");
  text.resize((text.size() + 7) / 8 * 8, ' ');
  return text;
}

}  // namespace imslam::nn
