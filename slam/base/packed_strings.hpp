#pragma once

#include <string>
#include <vector>

namespace imslam {

/// Several byte strings as one: each is preceded by its length in eight bytes, lowest first.
std::string pack_strings(const std::vector<std::string>& strings);

/// The inverse; ContractError if it was not packed so.
std::vector<std::string> unpack_strings(const std::string& packed);

/// A length as eight bytes, lowest first, and back.
std::string length_bytes(std::size_t length);
std::size_t length_of(const char* eight_bytes);

constexpr std::size_t kLengthBytes = 8;

}  // namespace imslam
