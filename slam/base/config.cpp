#include "slam/base/config.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"

namespace imslam {
namespace {

constexpr std::size_t kConfigSizeLimit = 1U << 20U;
constexpr int kMaximumDepth = 8;

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw InputError(where + ": " + what, ExitCode::kUsage);
}

std::string environment_name(const std::string& key) {
  std::string name = "IMSLAM_";
  for (const char c : key) {
    name += c == '.' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return name;
}

/// Whether `name` begins like a key: IMSLAM_PGO_. Other names may be those of other programs.
bool names_a_section(const std::string& name, const std::vector<std::string>& known) {
  const auto end = name.find('_', std::string_view("IMSLAM_").size());
  if (end == std::string::npos) return false;
  const std::string prefix = name.substr(0, end + 1);
  return std::any_of(known.begin(), known.end(), [&](const std::string& other) {
    return other.compare(0, prefix.size(), prefix) == 0;
  });
}

/// Shortest text that reads back as the same double.
std::string number_text(double value) { return fmt::format("{}", value); }

/// Text that YAML reads as itself without quotes; whatever is not surely plain gets quotes.
bool is_plain(const std::string& text) {
  if (parse_double(text)) return trim(text) == text;
  if (text.empty() || text == "null" || text == "Null" || text == "NULL") return false;
  const auto is_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '/';
  };
  const auto may_follow = [&](char c) { return is_word(c) || c == '.' || c == '-' || c == '+'; };
  return is_word(text.front()) && std::all_of(text.begin(), text.end(), may_follow);
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += std::string("\\") + c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result + "\"";
}

using Assignment = std::function<void(const std::string& key, const std::string& value, int line)>;

void walk(const YAML::Node& node,
          const std::string& key,
          int depth,
          const std::string& where,
          const Assignment& assign) {
  const int line = node.Mark().line + 1;
  const std::string here = fmt::format("{}:{}", where, line);
  if (depth > kMaximumDepth) fail(here, "nested too deeply");
  if (node.IsMap()) {
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) fail(here, "expected a name before the colon");
      const auto name = entry.first.as<std::string>();
      walk(entry.second, key.empty() ? name : key + "." + name, depth + 1, where, assign);
    }
  } else if (node.IsScalar()) {
    assign(key, node.as<std::string>(), line);
  } else if (!node.IsNull() || !key.empty()) {
    fail(here, fmt::format("'{}': expected a single value", key));
  }
}

}  // namespace

void Config::bind(const std::string& name, Field field) {
  field.default_text = field.print();
  const bool added = fields_.emplace(prefix_ + name, std::move(field)).second;
  expects(added, "Config: a key was bound twice");
}

void Config::field(const std::string& name, bool& value, const std::string& help) {
  const auto parse = [&value](const std::string& text) {
    if (text == "true" || text == "on" || text == "yes" || text == "1") return value = true, true;
    if (text == "false" || text == "off" || text == "no" || text == "0") {
      return value = false, true;
    }
    return false;
  };
  bind(name, {help, "", [&value] { return std::string(value ? "true" : "false"); }, parse,
              "true or false"});
}

void Config::field(const std::string& name, int& value, const std::string& help) {
  const auto parse = [&value](const std::string& text) {
    const auto number = parse_int64(text);
    if (!number || *number < INT32_MIN || *number > INT32_MAX) return false;
    value = static_cast<int>(*number);
    return true;
  };
  bind(name, {help, "", [&value] { return std::to_string(value); }, parse, "a whole number"});
}

void Config::field(const std::string& name, double& value, const std::string& help) {
  const auto parse = [&value](const std::string& text) {
    const auto number = parse_double(text);
    if (!number || !std::isfinite(*number)) return false;
    value = *number;
    return true;
  };
  bind(name, {help, "", [&value] { return number_text(value); }, parse, "a finite number"});
}

void Config::field(const std::string& name, std::string& value, const std::string& help) {
  const auto parse = [&value](const std::string& text) { return value = text, true; };
  bind(name, {help, "", [&value] { return value; }, parse, "a text"});
}

void Config::field(const std::string& name,
                   std::string& value,
                   const std::vector<std::string>& allowed,
                   const std::string& help) {
  const auto parse = [&value, allowed](const std::string& text) {
    if (std::find(allowed.begin(), allowed.end(), text) == allowed.end()) return false;
    value = text;
    return true;
  };
  bind(name, {help, "", [&value] { return value; }, parse,
              fmt::format("one of {}", fmt::join(allowed, ", "))});
}

void Config::assign(const std::string& key, const std::string& value, const std::string& where) {
  const auto found = fields_.find(key);
  if (found == fields_.end()) {
    const auto nearest = nearest_name(key, keys());
    fail(where,
         fmt::format("unknown key '{}'{}; `{}` lists all keys", key,
                     nearest ? fmt::format(", did you mean '{}'?", *nearest) : "", listing_));
  }
  if (!found->second.parse(value)) {
    fail(where, fmt::format("'{}' must be {}, got '{}'", key, found->second.type, value));
  }
}

void Config::load_file(const std::filesystem::path& file) {
  YAML::Node root;
  try {
    root = YAML::Load(read_file(file, kConfigSizeLimit));
  } catch (const YAML::Exception& error) {
    fail(fmt::format("{}:{}", file.string(), error.mark.line + 1), error.msg);
  } catch (const InputError& error) {
    throw InputError(error.what(), ExitCode::kUsage);
  }
  walk(root, "", 0, file.string(), [&](const auto& key, const auto& value, int line) {
    assign(key, value, fmt::format("{}:{}", file.string(), line));
  });
}

void Config::load_environment() {
  std::map<std::string, std::string> key_of;  // by the name in the environment
  std::vector<std::string> names;
  for (const std::string& key : keys()) {
    names.push_back(environment_name(key));
    key_of[names.back()] = key;
  }
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const std::size_t equals = std::min(text.find('='), text.size());
    const std::string name(text.substr(0, equals));
    const auto known = key_of.find(name);
    if (known != key_of.end() && equals < text.size()) {
      assign(known->second, std::string(text.substr(equals + 1)), "environment " + name);
    } else if (names_a_section(name, names)) {
      const auto nearest = nearest_name(name, names);
      fail("environment",
           fmt::format("unknown key '{}'{}; unset it", name,
                       nearest ? fmt::format(", did you mean '{}'?", *nearest) : ""));
    }
  }
}

void Config::set(std::string_view assignment, std::string_view origin) {
  const auto equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    fail(std::string(origin), fmt::format("expected key=value, got '{}'", assignment));
  }
  assign(std::string(trim(assignment.substr(0, equals))),
         std::string(trim(assignment.substr(equals + 1))), std::string(origin));
}

std::string Config::to_yaml(bool with_help) const {
  std::string text;
  std::vector<std::string> open;  // sections that the last line stood in
  for (const auto& [key, field] : fields_) {
    const auto dots = split(key, '.');
    const std::vector<std::string> sections(dots.begin(), dots.end() - 1);
    std::size_t shared = 0;
    while (shared < std::min(open.size(), sections.size()) && open[shared] == sections[shared]) {
      ++shared;
    }
    for (std::size_t i = shared; i < sections.size(); ++i) {
      text += std::string(2 * i, ' ') + sections[i] + ":\n";
    }
    open = sections;
    const std::string value = field.print();
    text += std::string(2 * sections.size(), ' ') + std::string(dots.back()) + ": ";
    text += is_plain(value) ? value : quoted(value);
    if (with_help) text += "  # " + field.help;
    text += "\n";
  }
  return text;
}

std::string Config::changes() const {
  std::string text;
  for (const auto& [key, field] : fields_) {
    const std::string value = field.print();
    if (value != field.default_text) text += key + "=" + value + "\n";
  }
  return text;
}

std::vector<std::string> Config::keys() const {
  std::vector<std::string> names;
  for (const auto& entry : fields_) names.push_back(entry.first);
  return names;
}

}  // namespace imslam
