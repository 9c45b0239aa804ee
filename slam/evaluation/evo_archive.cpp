#include "slam/evaluation/evo_archive.hpp"

#include <fmt/format.h>
#include <zip.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"

namespace imslam::evaluation {
namespace {

constexpr std::size_t kNpyAlignment = 64;

std::string npy_bytes(const std::string& shape, const double* values, std::size_t count) {
  constexpr std::size_t kPrefix = 10;  // magic, version, length of the header
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': {}, }}", shape);
  const std::size_t unpadded = kPrefix + header.size() + 1;
  header.append((kNpyAlignment - unpadded % kNpyAlignment) % kNpyAlignment, ' ');
  header += '\n';
  std::string bytes = "\x93NUMPY";
  bytes += '\x01';
  bytes += '\0';
  bytes += static_cast<char>(header.size() & 0xFFU);
  bytes += static_cast<char>(header.size() >> 8U);
  bytes += header;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, values + i, sizeof(bits));
    for (unsigned shift = 0; shift < 64; shift += 8) {
      bytes += static_cast<char>((bits >> shift) & 0xFFU);
    }
  }
  return bytes;
}

void require(bool condition, const char* step) {
  if (!condition) {
    throw InputError(fmt::format("result archive: libzip cannot {}", step), ExitCode::kOutput);
  }
}

/// A zip that grows in memory; write_file_atomic() then puts it on disk all or nothing.
class MemoryZip {
 public:
  MemoryZip() {
    zip_error_t error;
    zip_error_init(&error);
    source_ = zip_source_buffer_create(nullptr, 0, 0, &error);
    require(source_ != nullptr, "make a buffer");
    zip_source_keep(source_);  // outlives the archive, to be read back
    archive_ = zip_open_from_source(source_, ZIP_CREATE | ZIP_TRUNCATE, &error);
    zip_error_fini(&error);
    if (archive_ == nullptr) release();
    require(archive_ != nullptr, "open the buffer");
  }
  ~MemoryZip() { release(); }
  MemoryZip(const MemoryZip&) = delete;
  MemoryZip& operator=(const MemoryZip&) = delete;

  void add(const std::string& name, std::string content) {
    contents_.push_back(std::make_unique<std::string>(std::move(content)));
    const std::string& kept = *contents_.back();  // libzip reads it at close
    zip_source_t* source = zip_source_buffer(archive_, kept.data(), kept.size(), 0);
    require(source != nullptr, "take an entry");
    const zip_int64_t index = zip_file_add(archive_, name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) zip_source_free(source);
    require(index >= 0, "add an entry");
    const auto entry = static_cast<zip_uint64_t>(index);
    require(zip_set_file_compression(archive_, entry, ZIP_CM_STORE, 0) == 0, "store an entry");
    // A fixed date (1980-01-01, the first a zip knows): the same result gives the same bytes.
    require(zip_file_set_dostime(archive_, entry, 0, (1U << 5U) | 1U, 0) == 0, "date an entry");
  }

  std::string bytes() {
    require(zip_close(archive_) == 0, "write the archive");
    archive_ = nullptr;
    zip_stat_t info;
    require(zip_source_stat(source_, &info) == 0 && (info.valid & ZIP_STAT_SIZE) != 0, "measure");
    std::string bytes(info.size, '\0');
    require(zip_source_open(source_) == 0, "read back");
    const zip_int64_t read = zip_source_read(source_, bytes.data(), bytes.size());
    zip_source_close(source_);
    require(read == static_cast<zip_int64_t>(bytes.size()), "read back all");
    return bytes;
  }

 private:
  void release() {
    if (archive_ != nullptr) zip_discard(archive_);
    if (source_ != nullptr) zip_source_free(source_);
    archive_ = nullptr;
    source_ = nullptr;
  }

  zip_source_t* source_ = nullptr;
  zip_t* archive_ = nullptr;
  std::vector<std::unique_ptr<std::string>> contents_;
};

}  // namespace

std::string npy(const std::vector<double>& values) {
  return npy_bytes(fmt::format("({},)", values.size()), values.data(), values.size());
}

std::string npy(const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = matrix;
  return npy_bytes("(4, 4)", rows.data(), 16);
}

std::string evo_archive(const EvoResult& result) {
  const nlohmann::ordered_json info = {{"title", result.title},
                                       {"ref_name", result.reference_name},
                                       {"est_name", result.estimate_name},
                                       {"label", result.label}};
  const Statistics& s = result.stats;
  const nlohmann::ordered_json stats = {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
                                        {"std", s.std},   {"min", s.min},   {"max", s.max},
                                        {"sse", s.sse}};
  MemoryZip zip;
  // Names of files may be no UTF-8.
  zip.add("info.json", info.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  zip.add("stats.json", stats.dump());
  zip.add("error_array.npy", npy(result.errors));
  const std::pair<const char*, const std::vector<double>*> arrays[] = {
      {"seconds_from_start.npy", &result.seconds_from_start_s},
      {"timestamps.npy", &result.timestamps_s},
      {"distances_from_start.npy", &result.distances_from_start_m},
      {"distances.npy", &result.distances_m}};
  for (const auto& [name, values] : arrays) {
    if (!values->empty()) zip.add(name, npy(*values));
  }
  if (result.T_alignment) zip.add("alignment_transformation_sim3.npy", npy(*result.T_alignment));
  return zip.bytes();
}

void write_evo_archive(const std::filesystem::path& file, const EvoResult& result) {
  write_file_atomic(file, evo_archive(result));
}

}  // namespace imslam::evaluation
