#include "slam/base/packed_strings.hpp"

#include <cstdint>

#include "slam/base/error.hpp"

namespace imslam {

std::string length_bytes(std::size_t length) {
  std::string bytes;
  for (std::size_t i = 0; i < kLengthBytes; ++i) {
    bytes += static_cast<char>((static_cast<std::uint64_t>(length) >> (8 * i)) & 0xffU);
  }
  return bytes;
}

std::size_t length_of(const char* eight_bytes) {
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < kLengthBytes; ++i) {
    length |= static_cast<std::uint64_t>(static_cast<unsigned char>(eight_bytes[i])) << (8 * i);
  }
  return static_cast<std::size_t>(length);
}

std::string pack_strings(const std::vector<std::string>& strings) {
  std::string packed;
  for (const std::string& each : strings) packed += length_bytes(each.size()) + each;
  return packed;
}

std::vector<std::string> unpack_strings(const std::string& packed) {
  std::vector<std::string> strings;
  for (std::size_t at = 0; at < packed.size();) {
    expects(packed.size() - at >= kLengthBytes, "unpack_strings: cut in a length");
    const std::size_t length = length_of(packed.data() + at);
    at += kLengthBytes;
    expects(packed.size() - at >= length, "unpack_strings: cut in a string");
    strings.push_back(packed.substr(at, length));
    at += length;
  }
  return strings;
}

}  // namespace imslam
