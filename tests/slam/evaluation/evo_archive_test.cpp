#include "slam/evaluation/evo_archive.hpp"

#include <gtest/gtest.h>
#include <zip.h>

#include <cstdlib>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "slam/base/error.hpp"
#include "slam/evaluation/metric.hpp"
#include "slam/evaluation/rigid_matrix.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::evaluation {
namespace {

using testing::TempDir;

EvoResult some_result() {
  EvoResult result;
  result.title = "APE w.r.t. translation part (m)\n(with SE(3) Umeyama alignment)";
  result.label = "APE (m)";
  result.reference_name = "truth.tum";
  result.estimate_name = "estimate \"quoted\".tum";
  result.errors = {0.1, 1.0 / 3.0, 5e-324};
  result.stats = statistics(result.errors);
  result.timestamps_s = {1403636580.0, 1403636580.05, 1403636580.1};
  result.seconds_from_start_s = {0.0, 0.05, 0.1};
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T(0, 1) = 7.0;
  result.T_alignment = T;
  return result;
}

/// One pose per second, not turned.
PosePath path_through(const std::vector<Eigen::Vector3d>& positions) {
  PosePath path;
  for (const Eigen::Vector3d& p : positions) {
    path.stamps_s.push_back(static_cast<double>(path.size()));
    path.poses.push_back(rigid(Eigen::Matrix3d::Identity(), p));
  }
  return path;
}

EvoResult result_of(const PosePath& reference,
                    const PosePath& estimate,
                    const MetricOptions& options) {
  MatchedPaths matched;
  matched.reference = reference;
  matched.estimate = estimate;
  return evo_result(matched, options, measure(matched, options));
}

std::map<std::string, std::string> unzip(const std::filesystem::path& file) {
  std::map<std::string, std::string> entries;
  zip_t* archive = zip_open(file.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, nullptr);
  if (archive == nullptr) return entries;
  for (zip_uint64_t i = 0; i < zip_uint64_t(zip_get_num_entries(archive, 0)); ++i) {
    zip_stat_t info;
    zip_stat_index(archive, i, 0, &info);
    EXPECT_EQ(info.comp_method, ZIP_CM_STORE) << info.name;
    std::string content(info.size, '\0');
    zip_file_t* entry = zip_fopen_index(archive, i, 0);
    EXPECT_EQ(zip_fread(entry, content.data(), content.size()), zip_int64_t(content.size()));
    zip_fclose(entry);
    entries[info.name] = content;
  }
  zip_discard(archive);
  return entries;
}

TEST(Npy, HasTheBytesThatNumpyWrites) {
  // numpy.save of array([1.0, -2.0]), numpy 1.24.
  const std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }";
  const std::string bytes = npy(std::vector<double>{1.0, -2.0});
  ASSERT_EQ(bytes.size(), 128U + 16U);
  EXPECT_EQ(bytes.substr(0, 10), std::string("\x93NUMPY\x01\x00\x76\x00", 10));
  EXPECT_EQ(bytes.substr(10, header.size()), header);
  EXPECT_EQ(bytes.find_first_not_of(' ', 10 + header.size()), 127U);
  EXPECT_EQ(bytes[127], '\n');
  EXPECT_EQ(bytes.substr(128, 8), std::string("\0\0\0\0\0\0\xF0\x3F", 8));
  EXPECT_EQ(bytes.substr(136, 8), std::string("\0\0\0\0\0\0\0\xC0", 8));
}

TEST(Npy, WritesMatricesRowByRow) {
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  M(0, 1) = 7.0;
  const std::string bytes = npy(M);
  EXPECT_NE(bytes.find("'shape': (4, 4), "), std::string::npos);
  double second = 0.0;
  std::memcpy(&second, bytes.data() + bytes.size() - 15 * 8, sizeof(second));
  EXPECT_EQ(second, 7.0);
}

TEST(EvoArchive, HoldsWhatEvoLooksFor) {
  const TempDir folder;
  const auto file = folder.path() / "result.zip";
  write_evo_archive(file, some_result());
  const auto entries = unzip(file);
  ASSERT_EQ(entries.size(), 6U);
  const auto info = nlohmann::json::parse(entries.at("info.json"));
  EXPECT_EQ(info.at("est_name"), "estimate \"quoted\".tum");
  EXPECT_EQ(info.at("label"), "APE (m)");
  const auto stats = nlohmann::json::parse(entries.at("stats.json"));
  EXPECT_EQ(stats.at("rmse").get<double>(), some_result().stats.rmse);
  EXPECT_EQ(stats.size(), 7U);
  EXPECT_EQ(entries.at("error_array.npy"), npy(some_result().errors));
  EXPECT_EQ(entries.at("timestamps.npy"), npy(some_result().timestamps_s));
  EXPECT_EQ(entries.count("distances.npy"), 0U);  // not given
}

TEST(EvoArchive, TakesNamesThatAreNotUtf8) {
  const TempDir folder;
  EvoResult result = some_result();
  result.estimate_name = "caf\xE9.tum";
  write_evo_archive(folder.path() / "result.zip", result);
  const auto info = nlohmann::json::parse(unzip(folder.path() / "result.zip").at("info.json"));
  EXPECT_EQ(info.at("est_name"), "caf\xEF\xBF\xBD.tum");  // U+FFFD
}

TEST(EvoArchive, IsTheSameForTheSameResult) {
  EXPECT_EQ(evo_archive(some_result()), evo_archive(some_result()));
}

TEST(EvoArchive, IsReadByPythonAndByNumpyWhereInstalled) {
  if (std::system("python3 -c 'import zipfile' 2>/dev/null") != 0) GTEST_SKIP() << "no python3";
  const TempDir folder;
  const auto file = folder.path() / "result.zip";
  write_evo_archive(file, some_result());
  // clang-format off
  const auto script = folder.write("read.py", R"py(
import json, struct, sys, zipfile
archive = zipfile.ZipFile(sys.argv[1])
assert archive.testzip() is None
assert json.loads(archive.read("info.json"))["label"] == "APE (m)"
data = archive.read("error_array.npy")
assert len(data) == 128 + 24 and struct.unpack("<3d", data[-24:]) == (0.1, 1 / 3, 5e-324)
try:
    import io, numpy
    errors = numpy.load(io.BytesIO(data))
    assert errors.shape == (3,) and errors[1] == 1 / 3
    matrix = numpy.load(io.BytesIO(archive.read("alignment_transformation_sim3.npy")))
    assert matrix.shape == (4, 4) and matrix[0, 1] == 7
except ImportError:
    print("numpy is not installed: read with struct only")
)py");
  // clang-format on
  const std::string command = "python3 '" + script.string() + "' '" + file.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(EvoArchive, SaysWhereItCannotBeWritten) {
  try {
    write_evo_archive("/nowhere/result.zip", some_result());
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kOutput);
  }
}

TEST(EvoResult, OfRelativeErrorsMeasuresFromPairToPair) {
  const PosePath reference = path_through({{0, 0, 0}, {1, 1, 0}, {2, 0, 0}, {3, 1, 0}, {4, 0, 0}});
  const PosePath estimate = path_through({{0, 0, 0}, {3, 9, 0}, {6, 0, 0}, {9, 9, 0}, {12, 0, 0}});
  MetricOptions options;
  options.relative = true;
  options.delta.delta = 2;
  const EvoResult result = result_of(reference, estimate, options);
  EXPECT_EQ(result.errors, (std::vector<double>{4, 4}));
  EXPECT_EQ(result.timestamps_s, (std::vector<double>{2, 4}));
  EXPECT_EQ(result.distances_from_start_m, (std::vector<double>{2, 4}));  // not by the detours
  EXPECT_EQ(result.distances_m, (std::vector<double>{6, 12}));
}

TEST(EvoResult, OfAProjectionMeasuresAlongTheProjectedPaths) {
  const PosePath climb = path_through({{0, 0, 0}, {3, 4, 12}, {6, 8, 24}});
  MetricOptions options;
  options.projection = Plane::kXy;
  const EvoResult result = result_of(climb, climb, options);
  EXPECT_EQ(result.distances_from_start_m, (std::vector<double>{0, 5, 10}));
  EXPECT_EQ(result.distances_m, (std::vector<double>{0, 5, 10}));
}

}  // namespace
}  // namespace imslam::evaluation
