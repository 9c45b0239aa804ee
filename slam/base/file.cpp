#include "slam/base/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>

#include "slam/base/error.hpp"

namespace imslam {
namespace {

[[noreturn]] void fail_output(const std::filesystem::path& file, const char* step) {
  throw InputError(fmt::format("{}: cannot {} ({}); check free space and permissions",
                               file.string(), step, std::strerror(errno)),
                   ExitCode::kOutput);
}

/// Owns a file descriptor, and removes the temporary file unless the write was completed.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path path) : path_(std::move(path)) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (descriptor_ < 0) fail_output(path_, "create");
  }
  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!completed_) ::unlink(path_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  void write(std::string_view content) {
    while (!content.empty()) {
      const ssize_t written = ::write(descriptor_, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) fail_output(path_, "write");
      content.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  void rename_to(const std::filesystem::path& target) {
    if (::fsync(descriptor_) != 0) fail_output(path_, "flush");
    const int closed = ::close(descriptor_);
    descriptor_ = -1;
    if (closed != 0) fail_output(path_, "close");
    if (::rename(path_.c_str(), target.c_str()) != 0) fail_output(target, "replace");
    completed_ = true;
  }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  bool completed_ = false;
};

void flush_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // some file systems do not allow it; the rename has happened
  ::fsync(descriptor);
  ::close(descriptor);
}

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    expects(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1,
            "Sha256: OpenSSL refused to start");
  }
  void add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &size);
    std::string text;
    for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest.at(i));
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string read_file(const std::filesystem::path& file, std::size_t size_limit) {
  std::error_code ignored;  // whatever is wrong with it, opening it says so
  if (std::filesystem::is_directory(file, ignored)) {
    throw InputError(file.string() + ": is a folder, a file was expected");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw InputError(fmt::format("{}: cannot be opened ({})", file.string(), std::strerror(errno)));
  }
  std::string content;
  std::array<char, 1U << 16U> chunk{};
  while (stream.read(chunk.data(), chunk.size()) || stream.gcount() > 0) {
    content.append(chunk.data(), static_cast<std::size_t>(stream.gcount()));
    if (content.size() > size_limit) {
      throw InputError(fmt::format("{}: larger than the limit of {} bytes; is it the right file?",
                                   file.string(), size_limit));
    }
  }
  if (stream.bad()) throw InputError(file.string() + ": reading failed");
  return content;
}

void write_file_atomic(const std::filesystem::path& file, std::string_view content) {
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  TemporaryFile temporary(folder / fmt::format(".{}.{}.tmp", file.filename().string(), ::getpid()));
  temporary.write(content);
  temporary.rename_to(file);
  flush_folder(folder);
}

std::string sha256(std::string_view content) {
  Sha256 hash;
  hash.add(content);
  return hash.hex();
}

std::string sha256_of_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file.string() + ": cannot be opened");
  Sha256 hash;
  std::array<char, 1U << 16U> chunk{};
  while (stream.read(chunk.data(), chunk.size()) || stream.gcount() > 0) {
    hash.add({chunk.data(), static_cast<std::size_t>(stream.gcount())});
  }
  return hash.hex();
}

}  // namespace imslam
