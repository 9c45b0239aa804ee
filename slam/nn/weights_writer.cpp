#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "slam/base/file.hpp"
#include "slam/nn/weights_io.hpp"

namespace imslam::nn {
namespace {

template <typename T>
void append(std::string& bytes, const T& number) {
  const auto* const raw = reinterpret_cast<const char*>(&number);
  bytes.append(raw, sizeof(T));
}

void expect_finite(const std::string& name, double number) {
  if (std::isfinite(number)) return;
  throw InputError("tensor '" + name +
                       "' holds a number that is not finite in the type it is written in; has the "
                       "training diverged?",
                   ExitCode::kModel);
}

}  // namespace

void WeightsWriter::add_piece(const std::string& name, Piece piece) {
  if (!pieces_.emplace(name, std::move(piece)).second) {
    throw ContractError("WeightsWriter: tensor '" + name + "' stands twice");
  }
}

void WeightsWriter::add(const std::string& name, const Tensor<float>& numbers, NumberType type) {
  expects(type == NumberType::kF32 || type == NumberType::kF16, "WeightsWriter: F32 or F16");
  std::string bytes;
  bytes.reserve(static_cast<std::size_t>(numbers.size()) * bytes_of(type));
  for (Index i = 0; i < numbers.size(); ++i) {
    if (type == NumberType::kF32) {
      expect_finite(name, static_cast<double>(numbers[i]));
      append(bytes, numbers[i]);
    } else {
      const Eigen::half half(numbers[i]);
      expect_finite(name, static_cast<double>(static_cast<float>(half)));
      append(bytes, half);
    }
  }
  add_piece(name, {type, numbers.shape(), std::move(bytes)});
}

void WeightsWriter::add(const std::string& name, const Tensor<double>& numbers) {
  std::string bytes;
  for (Index i = 0; i < numbers.size(); ++i) {
    expect_finite(name, numbers[i]);
    append(bytes, numbers[i]);
  }
  add_piece(name, {NumberType::kF64, numbers.shape(), std::move(bytes)});
}

void WeightsWriter::add(const std::string& name, std::int64_t number) {
  std::string bytes;
  append(bytes, number);
  add_piece(name, {NumberType::kI64, Shape{1}, std::move(bytes)});
}

std::string WeightsWriter::bytes(Metadata metadata) const {
  WeightsHeader header;
  std::string data;
  for (const auto& [name, piece] : pieces_) {
    const std::uint64_t begin = data.size();
    data += piece.bytes;
    header.tensors.push_back({name, piece.type, piece.shape, begin, data.size()});
  }
  metadata[kHashKey] = sha256(data);
  header.metadata = std::move(metadata);
  const std::string json = print_weights_header(header);
  std::string file;
  file.reserve(8 + json.size() + data.size());
  append(file, static_cast<std::uint64_t>(json.size()));
  return file + json + data;
}

void WeightsWriter::write(const std::filesystem::path& file, const Metadata& metadata) const {
  write_file_atomic(file, bytes(metadata));
}

void save_parameters(const std::filesystem::path& file,
                     const ParameterList<float>& parameters,
                     const ModelCard& card,
                     NumberType type) {
  WeightsWriter writer;
  for (const Parameter<float>* parameter : parameters) {
    writer.add(parameter->name, parameter->value, type);
  }
  Metadata metadata;
  put_card(card, metadata);
  writer.write(file, metadata);
}

template <typename S>
void add_state(WeightsWriter& writer, const std::string& prefix, const OptimizerState<S>& state) {
  writer.add(prefix + "steps", state.steps);
  for (const NamedTensor<S>& named : state.tensors) writer.add(prefix + named.name, named.tensor);
}

template void add_state(WeightsWriter&, const std::string&, const OptimizerState<float>&);
template void add_state(WeightsWriter&, const std::string&, const OptimizerState<double>&);

}  // namespace imslam::nn
