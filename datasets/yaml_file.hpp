#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace YAML {
class Node;
}

namespace imslam::datasets {

/// One value of a calibration file, with its place for messages.
///
/// Every accessor throws InputError(kCalibration) "file:line: key: expected ..." if the value is
/// missing, of another type or not finite.
class YamlValue {
 public:
  YamlValue(std::shared_ptr<const YAML::Node> node, std::string file, std::string path);

  bool has(const std::string& key) const;
  YamlValue at(const std::string& key) const;  ///< a missing key is an error naming the nearest one

  double number() const;
  std::string text() const;
  std::vector<double> numbers() const;                   ///< a list of any length
  std::vector<double> numbers(std::size_t count) const;  ///< a list of this length

  /// {rows, cols, data: [16]}, [16] or four rows of four.
  Eigen::Matrix4d matrix4() const;

  std::string where() const;  ///< "file:line: key"
  [[noreturn]] void fail(const std::string& expected) const;

 private:
  std::shared_ptr<const YAML::Node> node_;
  std::string file_;
  std::string path_;
};

/// Reads a YAML file of at most 1 MB; OpenCV's "%YAML:1.0" first line is accepted.
/// InputError(kCalibration) "file:line: ..." on syntax errors.
YamlValue load_yaml(const std::filesystem::path& file);

/// The same from memory; `name` stands for the file in messages.
YamlValue parse_yaml(std::string text, const std::string& name);

}  // namespace imslam::datasets
