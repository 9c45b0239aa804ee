#include "slam/base/yaml_reader.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"

namespace imslam {
namespace {

constexpr std::size_t kSizeLimit = 1U << 20U;

[[noreturn]] void fail_at(const std::string& file, int line, const std::string& what) {
  throw InputError(fmt::format("{}:{}: {}", file, line, what), ExitCode::kUsage);
}

/// The line of a value; that of `outer` where yaml-cpp does not know it.
int line_of(const YAML::Node& node, int outer) {
  return node.IsDefined() && !node.Mark().is_null() ? node.Mark().line + 1 : outer;
}

}  // namespace

YamlEntry::YamlEntry(std::shared_ptr<const YAML::Node> node,
                     std::string file,
                     int line,
                     std::string name)
    : node_(std::move(node)), file_(std::move(file)), line_(line), name_(std::move(name)) {}

void YamlEntry::fail(const std::string& expected) const {
  fail_at(file_, line_, (name_.empty() ? "" : name_ + ": ") + "expected " + expected);
}

std::vector<std::string> YamlEntry::keys() const {
  if (!node_->IsMap()) fail("keys with values (key: value)");
  std::vector<std::string> names;
  for (const auto& entry : *node_) {
    if (!entry.first.IsScalar()) fail("a name before each colon");
    names.push_back(entry.first.Scalar());
  }
  return names;
}

const YamlEntry& YamlEntry::only(const std::vector<std::string>& known) const {
  const std::vector<std::string> given = keys();
  for (auto key = given.begin(); key != given.end(); ++key) {
    const auto entry = std::next(node_->begin(), std::distance(given.begin(), key));
    const int line = line_of(entry->first, line_);
    if (std::find(known.begin(), known.end(), *key) == known.end()) {
      const auto nearest = nearest_name(*key, known);
      fail_at(file_, line,
              fmt::format("unknown key '{}'{}; known here: {}", *key,
                          nearest ? fmt::format(", did you mean '{}'?", *nearest) : "",
                          fmt::join(known, ", ")));
    }
    if (std::find(given.begin(), key, *key) != key) {
      fail_at(file_, line, fmt::format("key '{}' is given twice; remove one", *key));
    }
  }
  return *this;
}

std::optional<YamlEntry> YamlEntry::find(const std::string& key) const {
  if (!node_->IsMap()) fail("keys with values (key: value)");
  const YAML::Node& map = *node_;  // const: operator[] must not insert
  YAML::Node value = map[key];
  if (!value.IsDefined() || value.IsNull()) return std::nullopt;
  const int line = line_of(value, line_);
  return YamlEntry(std::make_shared<const YAML::Node>(std::move(value)), file_, line, key);
}

YamlEntry YamlEntry::at(const std::string& key) const {
  auto value = find(key);
  if (!value) fail(fmt::format("the key '{}' with a value", key));
  return *std::move(value);
}

std::string YamlEntry::text() const {
  if (!node_->IsScalar() || trim(node_->Scalar()).empty()) fail("a text");
  return node_->Scalar();
}

double YamlEntry::number() const {
  const auto value = node_->IsScalar() ? parse_double(node_->Scalar()) : std::nullopt;
  if (!value || !std::isfinite(*value)) fail("a finite number");
  return *value;
}

bool YamlEntry::is_list() const { return node_->IsSequence(); }

std::vector<YamlEntry> YamlEntry::items() const {
  if (!is_list()) fail("a list");
  std::vector<YamlEntry> values;
  for (const YAML::Node& entry : *node_) {
    values.emplace_back(std::make_shared<const YAML::Node>(entry), file_, line_of(entry, line_),
                        fmt::format("{}[{}]", name_, values.size()));
  }
  return values;
}

YamlEntry read_yaml(const std::filesystem::path& file) {
  try {
    auto root = std::make_shared<const YAML::Node>(YAML::Load(read_file(file, kSizeLimit)));
    return {std::move(root), file.string(), 1, ""};
  } catch (const YAML::Exception& error) {
    fail_at(file.string(), error.mark.line + 1,
            fmt::format("not valid YAML ({}); correct the syntax", error.msg));
  } catch (const InputError& error) {
    throw InputError(error.what(), ExitCode::kUsage);
  }
}

}  // namespace imslam
