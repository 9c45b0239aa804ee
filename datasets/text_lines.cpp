#include "datasets/text_lines.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace imslam::datasets {
namespace {

std::unique_ptr<std::istream> open(const std::filesystem::path& file) {
  std::error_code ignored;
  const auto status = std::filesystem::status(file, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    // A pipe or a device could block or never end.
    throw InputError(file.string() + ": not a regular file; give the text file itself");
  }
  auto stream = std::make_unique<std::ifstream>(file, std::ios::binary);
  if (!*stream) {
    throw InputError(fmt::format("{}: cannot be opened ({}); check name and permissions",
                                 file.string(), std::strerror(errno)));
  }
  return stream;
}

}  // namespace

LineReader::LineReader(const std::filesystem::path& file)
    : name_(file.string()), stream_(open(file)), buffer_(kMaxLineBytes + 2) {}

LineReader::LineReader(std::string name, const std::string& text)
    : name_(std::move(name)),
      stream_(std::make_unique<std::istringstream>(text)),
      buffer_(kMaxLineBytes + 2) {}

bool LineReader::next() {
  if (!stream_->good()) return false;
  stream_->getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  const auto extracted = static_cast<std::size_t>(stream_->gcount());
  if (stream_->bad()) throw InputError(name_ + ": reading failed; check the disk");
  if (stream_->eof() && extracted == 0) return false;
  ++number_;
  if (stream_->fail()) {
    throw InputError(
        fmt::format("{}: line longer than {} bytes; is this the text file it should be?", where(),
                    kMaxLineBytes));
  }
  terminated_ = !stream_->eof();
  line_ = std::string_view(buffer_.data(), terminated_ ? extracted - 1 : extracted);
  if (number_ == 1 && line_.substr(0, 3) == "\xEF\xBB\xBF") line_.remove_prefix(3);
  if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
  return true;
}

std::string LineReader::where(std::size_t column) const {
  return column == 0 ? fmt::format("{}:{}", name_, number_)
                     : fmt::format("{}:{}:{}", name_, number_, column);
}

}  // namespace imslam::datasets
