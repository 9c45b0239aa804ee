#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace imslam {

/// The whole of a text file. Throws InputError if it cannot be read or exceeds `size_limit` bytes
/// (so that /dev/zero or a 1 GB line ends in a message, not in swap).
std::string read_file(const std::filesystem::path& file, std::size_t size_limit = 256U << 20U);

/// Writes all or nothing: temporary file in the same folder, fsync, rename, fsync of the folder.
/// Throws InputError(kOutput) and leaves an older file untouched if anything fails.
void write_file_atomic(const std::filesystem::path& file, std::string_view content);

/// Lower-case hexadecimal SHA-256.
std::string sha256(std::string_view content);
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace imslam
