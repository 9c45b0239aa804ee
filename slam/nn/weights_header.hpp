#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "slam/nn/shape.hpp"

namespace imslam::nn {

enum class NumberType { kF16, kBF16, kF32, kF64, kI64 };

const char* name_of(NumberType type);  ///< "F32"
std::size_t bytes_of(NumberType type);

/// Free text about the file by key, e.g. the model card; at most 16 kB each.
using Metadata = std::map<std::string, std::string>;

/// Where one tensor lies in a weight file.
struct TensorEntry {
  std::string name;
  NumberType type = NumberType::kF32;
  Shape shape;
  std::uint64_t begin = 0;  ///< [bytes] from the start of the data
  std::uint64_t end = 0;
};

/// The JSON part of a safetensors file:
///
///   8 bytes length n, little endian | n bytes JSON | data
///   {"__metadata__": {"key": "text", ...},
///    "name": {"dtype": "F32", "shape": [2,3], "data_offsets": [0,24]}, ...}
struct WeightsHeader {
  std::vector<TensorEntry> tensors;  ///< by offset
  Metadata metadata;
};

/// Reads the JSON and holds it against the number of data bytes that follow. Refused, with
/// InputError(kModel) "file: ...": anything but the above, duplicate keys, other types, more than 5
/// sizes, products that overflow, ranges that are not type x shape, gaps, overlaps, bytes left
/// over. Grows only by what it has accepted: a deep or long JSON is refused at the first odd token.
WeightsHeader parse_weights_header(const std::string& file,
                                   std::string_view json,
                                   std::uint64_t data_bytes);

/// The JSON of a header, padded with blanks to a multiple of 8 bytes. Equal headers, equal bytes.
std::string print_weights_header(const WeightsHeader& header);

/// What every weight file error says: "file: what".
[[noreturn]] void fail_model(const std::string& file, const std::string& what);

}  // namespace imslam::nn
