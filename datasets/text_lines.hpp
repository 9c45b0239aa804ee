#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "slam/base/error.hpp"

namespace imslam::datasets {

/// Streams the lines of a text file; memory does not grow with the file.
///
/// Accepted: LF and CRLF ends, a UTF-8 byte order mark, a missing final newline.
/// InputError(kData): the file cannot be read, is not a regular file, or has a line above
/// kMaxLineBytes (a binary file, /dev/zero).
class LineReader {
 public:
  static constexpr std::size_t kMaxLineBytes = 64U * 1024U;

  explicit LineReader(const std::filesystem::path& file);

  /// Lines of a text in memory; `name` stands for the file in messages.
  LineReader(std::string name, const std::string& text);

  /// Moves to the next line; false at the end.
  bool next();

  std::string_view line() const { return line_; }  ///< without its end; valid until next()
  std::size_t number() const { return number_; }   ///< from 1
  bool terminated() const { return terminated_; }  ///< false: the file ends inside this line
  const std::string& name() const { return name_; }

  /// "file:line" or, if a column (from 1) is given, "file:line:column".
  std::string where(std::size_t column = 0) const;

 private:
  std::string name_;
  std::unique_ptr<std::istream> stream_;
  std::vector<char> buffer_;
  std::string_view line_;
  std::size_t number_ = 0;
  bool terminated_ = true;
};

}  // namespace imslam::datasets
