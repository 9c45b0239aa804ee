#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace YAML {
class Node;
}

namespace imslam {

/// One value of a YAML file that is more than the flat keys of Config: lists, maps of any name.
///
/// Nothing is overlooked: a reader names the keys that it knows with only(); every other key, a key
/// given twice, and every value of another type is InputError(kUsage) "file:line: ...".
class YamlEntry {
 public:
  YamlEntry(std::shared_ptr<const YAML::Node> node, std::string file, int line, std::string name);

  /// This is a map, and no key is in it but these.
  const YamlEntry& only(const std::vector<std::string>& keys) const;
  std::vector<std::string> keys() const;  ///< of a map, in the file's order

  YamlEntry at(const std::string& key) const;  ///< of a map; a missing key is an error
  std::optional<YamlEntry> find(const std::string& key) const;  ///< likewise, or nothing

  std::string text() const;              ///< one word or line, not empty
  double number() const;                 ///< finite
  bool is_list() const;                  ///< else a single value or a map
  std::vector<YamlEntry> items() const;  ///< of a list

  [[noreturn]] void fail(const std::string& expected) const;

 private:
  std::shared_ptr<const YAML::Node> node_;
  std::string file_;
  int line_ = 0;
  std::string name_;  ///< its key, for messages
};

/// Reads a file of at most 1 MB. Throws InputError(kUsage).
YamlEntry read_yaml(const std::filesystem::path& file);

}  // namespace imslam
