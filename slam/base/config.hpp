#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace imslam {

/// Names the fields of option structs so that files, environment and command line can set them.
///
/// Every option struct has `void describe(Config& config)` that lists its fields, and a
/// `validate()`. The struct's header holds the defaults; the config only overrides:
///
///   defaults  <  file (load_file)  <  environment IMSLAM_PGO_HUBER (load_environment)  <  set()
///
///   PgoOptions pgo;
///   Config config;
///   config.section("pgo", pgo);            // calls pgo.describe(config), keys "pgo.huber", ...
///   config.set("pgo.huber=1.0", "--set");
///
/// The config holds references: the option structs must outlive it.
class Config {
 public:
  /// Called inside describe(): binds `name` of the current section to `field`.
  void field(const std::string& name, bool& value, const std::string& help);
  void field(const std::string& name, int& value, const std::string& help);
  void field(const std::string& name, double& value, const std::string& help);
  void field(const std::string& name, std::string& value, const std::string& help);
  /// A choice out of `allowed`; anything else is an error that lists them.
  void field(const std::string& name,
             std::string& value,
             const std::vector<std::string>& allowed,
             const std::string& help);

  template <typename Options>
  void section(const std::string& name, Options& options) {
    const std::string outer = prefix_;
    prefix_ += name + ".";
    options.describe(*this);
    prefix_ = outer;
  }

  /// Reads a YAML file of nested sections. Throws InputError(kUsage) "file:line: ..." on unknown
  /// keys (naming the nearest known one), wrong types and syntax errors.
  void load_file(const std::filesystem::path& file);

  /// Applies IMSLAM_SECTION_FIELD for each known key that is set in the environment. Throws
  /// InputError(kUsage) if one names a section and no key of it.
  void load_environment();

  /// One "key=value"; `origin` stands in the error message.
  void set(std::string_view assignment, std::string_view origin);

  /// All keys with their present values, nested, with the help texts as comments if asked.
  std::string to_yaml(bool with_help = false) const;

  /// Keys whose value differs from the one that they had when bound, as "key=value" lines.
  std::string changes() const;

  std::vector<std::string> keys() const;

  /// The command that messages about unknown keys point to.
  void listed_by(const std::string& command) { listing_ = command; }

 private:
  struct Field {
    std::string help;
    std::string default_text;
    std::function<std::string()> print;
    std::function<bool(const std::string&)> parse;  ///< false: not of the type
    std::string type;
  };

  void bind(const std::string& name, Field field);
  void assign(const std::string& key, const std::string& value, const std::string& where);

  std::string prefix_;
  std::string listing_ = "imslam config dump";
  std::map<std::string, Field> fields_;
};

}  // namespace imslam
