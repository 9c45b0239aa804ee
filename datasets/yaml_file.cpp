#include "datasets/yaml_file.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"

namespace imslam::datasets {
namespace {

constexpr std::size_t kMaxYamlBytes = 1U << 20U;
constexpr std::size_t kMaxListLength = 4096;

std::vector<std::string> keys_of(const YAML::Node& node) {
  std::vector<std::string> keys;
  for (const auto& entry : node) {
    if (entry.first.IsScalar()) keys.push_back(entry.first.Scalar());
  }
  return keys;
}

}  // namespace

YamlValue::YamlValue(std::shared_ptr<const YAML::Node> node, std::string file, std::string path)
    : node_(std::move(node)), file_(std::move(file)), path_(std::move(path)) {}

std::string YamlValue::where() const {
  const YAML::Mark mark = node_->Mark();
  const std::string line = mark.is_null() ? "" : fmt::format(":{}", mark.line + 1);
  return file_ + line + (path_.empty() ? "" : ": " + path_);
}

void YamlValue::fail(const std::string& expected) const {
  throw InputError(fmt::format("{}: expected {}", where(), expected), ExitCode::kCalibration);
}

bool YamlValue::has(const std::string& key) const {
  return node_->IsMap() && (*node_)[key].IsDefined() && !(*node_)[key].IsNull();
}

YamlValue YamlValue::at(const std::string& key) const {
  if (!node_->IsMap()) fail(fmt::format("a map with the key '{}'", key));
  if (!has(key)) {
    const auto nearest = nearest_name(key, keys_of(*node_));
    fail(fmt::format("the key '{}'{}", key,
                     nearest ? fmt::format("; is it spelled '{}' here?", *nearest) : ""));
  }
  return {std::make_shared<const YAML::Node>((*node_)[key]), file_,
          path_.empty() ? key : path_ + "." + key};
}

std::string YamlValue::text() const {
  if (!node_->IsScalar()) fail("one word");
  return node_->Scalar();
}

double YamlValue::number() const {
  const auto value = node_->IsScalar() ? parse_double(node_->Scalar()) : std::nullopt;
  if (!value || !std::isfinite(*value)) fail("a finite number");
  return *value;
}

std::vector<double> YamlValue::numbers() const {
  if (!node_->IsSequence() || node_->size() > kMaxListLength) fail("a list of numbers");
  std::vector<double> values;
  for (const YAML::Node& entry : *node_) {
    const auto value = entry.IsScalar() ? parse_double(entry.Scalar()) : std::nullopt;
    if (!value || !std::isfinite(*value)) fail("a list of finite numbers");
    values.push_back(*value);
  }
  return values;
}

std::vector<double> YamlValue::numbers(std::size_t count) const {
  std::vector<double> values = numbers();
  if (values.size() != count) {
    fail(fmt::format("{} numbers, found {}", count, values.size()));
  }
  return values;
}

Eigen::Matrix4d YamlValue::matrix4() const {
  std::vector<double> values;
  if (node_->IsMap()) {
    values = at("data").numbers(16);
  } else if (node_->IsSequence() && node_->size() == 4 && (*node_)[0].IsSequence()) {
    for (std::size_t row = 0; row < 4; ++row) {
      const YamlValue entry(std::make_shared<const YAML::Node>((*node_)[row]), file_,
                            fmt::format("{}[{}]", path_, row));
      for (const double value : entry.numbers(4)) values.push_back(value);
    }
  } else {
    values = numbers(16);
  }
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
}

YamlValue load_yaml(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored)) {
    throw InputError(file.string() + ": not a regular file; give the YAML file itself",
                     ExitCode::kCalibration);  // a pipe could block for ever
  }
  std::string text;
  try {
    text = read_file(file, kMaxYamlBytes);
  } catch (const InputError& error) {
    throw InputError(error.what(), ExitCode::kCalibration);
  }
  if (trim(text).empty()) {
    throw InputError(file.string() + ": is empty; put the calibration back",
                     ExitCode::kCalibration);
  }
  return parse_yaml(std::move(text), file.string());
}

YamlValue parse_yaml(std::string text, const std::string& name) {
  if (text.rfind("\xEF\xBB\xBF", 0) == 0) text.erase(0, 3);
  if (text.rfind("%YAML:", 0) == 0) text[0] = '#';  // OpenCV's spelling is not YAML
  try {
    return {std::make_shared<const YAML::Node>(YAML::Load(text)), name, ""};
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}:{}: not valid YAML ({}); correct the syntax", name,
                                 error.mark.line + 1, error.mark.column + 1, error.msg),
                     ExitCode::kCalibration);
  }
}

}  // namespace imslam::datasets
