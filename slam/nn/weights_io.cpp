#include "slam/nn/weights_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "slam/base/file.hpp"

namespace imslam::nn {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the format is little endian");

constexpr std::size_t kLengthBytes = 8;
constexpr std::uint64_t kLongestHeader = std::uint64_t{16} << 20U;
constexpr std::uint64_t kLargestFile = std::uint64_t{4} << 30U;

template <typename T>
T number_at(const char* bytes, std::size_t i) {
  T number;
  std::memcpy(&number, bytes + i * sizeof(T), sizeof(T));
  return number;
}

/// Calls visit(i, number) for the numbers of a tensor in the type in which they are stored.
template <typename Visit>
void for_each_number(const TensorEntry& tensor, const char* bytes, const Visit& visit) {
  const auto count = static_cast<std::size_t>(tensor.shape.size());
  for (std::size_t i = 0; i < count; ++i) {
    switch (tensor.type) {
      case NumberType::kF16:
        visit(i, static_cast<float>(number_at<Eigen::half>(bytes, i)));
        break;
      case NumberType::kBF16:
        visit(i, static_cast<float>(number_at<Eigen::bfloat16>(bytes, i)));
        break;
      case NumberType::kF32:
        visit(i, number_at<float>(bytes, i));
        break;
      case NumberType::kF64:
        visit(i, number_at<double>(bytes, i));
        break;
      case NumberType::kI64:
        visit(i, number_at<std::int64_t>(bytes, i));
        break;
    }
  }
}

/// Reads a file of known size at once: growing piece by piece would need more than twice of it.
std::string read_bytes(const std::filesystem::path& file) {
  std::error_code error;
  const std::string name = file.string();
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(name + ": no such weight file; give the path of a .safetensors file",
                     ExitCode::kModel);
  }
  const std::uint64_t size = std::filesystem::file_size(file, error);
  if (error || size > kLargestFile) fail_model(name, "the size is unknown or above 4 GiB");
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(size, '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    fail_model(name, "reading failed");
  }
  return bytes;
}

std::string three_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(names.size(), 3); ++i) {
    text += (i > 0 ? ", " : "") + names[i];
  }
  return names.size() > 3 ? fmt::format("{} and {} more", text, names.size() - 3) : text;
}

bool starts_with(const std::string& text, const std::string& prefix) {
  return text.compare(0, prefix.size(), prefix) == 0;
}

/// What of the file does not fit to the parameters; empty if all does.
std::string difference(const WeightsFile& file,
                       const ParameterList<float>& parameters,
                       const std::string& prefix) {
  std::vector<std::string> missing;
  std::vector<std::string> other_shape;
  std::vector<std::string> unknown;
  for (const Parameter<float>* parameter : parameters) {
    const TensorEntry* const entry = file.find(prefix + parameter->name);
    if (entry == nullptr) {
      missing.push_back(prefix + parameter->name);
    } else if (entry->shape != parameter->value.shape()) {
      other_shape.push_back(fmt::format("{} {} instead of {}", entry->name, entry->shape.text(),
                                        parameter->value.shape().text()));
    }
  }
  for (const TensorEntry& entry : file.tensors()) {
    const bool known = std::any_of(parameters.begin(), parameters.end(),
                                   [&](const auto* p) { return entry.name == prefix + p->name; });
    if (starts_with(entry.name, prefix) && !known) unknown.push_back(entry.name);
  }
  std::string problem;
  if (!missing.empty()) problem += "missing tensors: " + three_of(missing) + "; ";
  if (!unknown.empty()) problem += "unknown tensors: " + three_of(unknown) + "; ";
  if (!other_shape.empty()) problem += "wrong shapes: " + three_of(other_shape) + "; ";
  return problem;
}

}  // namespace

WeightsFile WeightsFile::read(const std::filesystem::path& file) {
  return parse(file.string(), read_bytes(file));
}

WeightsFile WeightsFile::parse(std::string name, std::string bytes) {
  WeightsFile file;
  file.name_ = std::move(name);
  file.bytes_ = std::move(bytes);
  if (file.bytes_.size() < kLengthBytes) fail_model(file.name_, "shorter than 8 bytes");
  const auto length = number_at<std::uint64_t>(file.bytes_.data(), 0);
  const std::uint64_t rest = file.bytes_.size() - kLengthBytes;
  if (length > rest || length > kLongestHeader) {
    fail_model(file.name_,
               fmt::format("a header of {} bytes is stated, {} bytes follow (at most {})", length,
                           rest, kLongestHeader));
  }
  file.data_start_ = kLengthBytes + static_cast<std::size_t>(length);
  const std::string_view json(file.bytes_.data() + kLengthBytes, static_cast<std::size_t>(length));
  file.header_ = parse_weights_header(file.name_, json, file.data().size());
  for (const TensorEntry& tensor : file.header_.tensors) {
    for_each_number(tensor, file.data().data() + tensor.begin, [&](std::size_t i, auto number) {
      if (std::isfinite(static_cast<double>(number))) return;
      fail_model(file.name_, fmt::format("tensor '{}' holds a number at {} that is not finite",
                                         tensor.name, i));
    });
  }
  const auto stated = file.header_.metadata.find(kHashKey);
  if (stated != file.header_.metadata.end() && stated->second != file.data_sha256()) {
    fail_model(file.name_, "the tensors are not those that the sha256 in the metadata was made of");
  }
  return file;
}

std::string WeightsFile::data_sha256() const { return sha256(data()); }

const TensorEntry* WeightsFile::find(std::string_view tensor) const {
  const auto found = std::find_if(header_.tensors.begin(), header_.tensors.end(),
                                  [&](const TensorEntry& entry) { return entry.name == tensor; });
  return found == header_.tensors.end() ? nullptr : &*found;
}

template <typename S>
void WeightsFile::read_into(const std::string& tensor, Tensor<S>& numbers) const {
  const TensorEntry* const entry = find(tensor);
  if (entry == nullptr) fail_model(name_, "tensor '" + tensor + "' is missing");
  if (entry->shape != numbers.shape()) {
    fail_model(name_, fmt::format("tensor '{}' is {}, expected {}", tensor, entry->shape.text(),
                                  numbers.shape().text()));
  }
  for_each_number(*entry, data().data() + entry->begin, [&](std::size_t i, auto number) {
    numbers[static_cast<Index>(i)] = static_cast<S>(number);
  });
}

std::int64_t WeightsFile::integer(const std::string& tensor) const {
  const TensorEntry* const entry = find(tensor);
  if (entry == nullptr || entry->type != NumberType::kI64 || entry->shape != Shape{1}) {
    fail_model(name_, "tensor '" + tensor + "' is not one I64 number");
  }
  return number_at<std::int64_t>(data().data() + entry->begin, 0);
}

void load_parameters(const WeightsFile& file,
                     const ParameterList<float>& parameters,
                     const std::string& prefix) {
  const std::string problem = difference(file, parameters, prefix);
  if (!problem.empty()) {
    throw InputError(file.name() + ": the weights of another network; " + problem +
                         "give the weights that were trained for this one",
                     ExitCode::kModel);
  }
  for (Parameter<float>* parameter : parameters) {
    file.read_into(prefix + parameter->name, parameter->value);
  }
}

template <typename S>
OptimizerState<S> state_of(const WeightsFile& file, const std::string& prefix) {
  OptimizerState<S> state;
  state.steps = file.integer(prefix + "steps");
  for (const TensorEntry& entry : file.tensors()) {
    if (entry.name.compare(0, prefix.size(), prefix) != 0 || entry.name == prefix + "steps")
      continue;
    state.tensors.push_back({entry.name.substr(prefix.size()), Tensor<S>(entry.shape)});
    file.read_into(entry.name, state.tensors.back().tensor);
  }
  return state;
}

template void WeightsFile::read_into(const std::string&, Tensor<float>&) const;
template void WeightsFile::read_into(const std::string&, Tensor<double>&) const;
template OptimizerState<float> state_of(const WeightsFile&, const std::string&);
template OptimizerState<double> state_of(const WeightsFile&, const std::string&);

}  // namespace imslam::nn
