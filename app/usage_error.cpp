#include "app/usage_error.hpp"

#include <fmt/format.h>

#include <vector>

#include "slam/base/text.hpp"

namespace imslam::app {
namespace {

/// From the root to the innermost subcommand that was typed.
std::vector<const CLI::App*> chosen_commands(const CLI::App* root) {
  std::vector<const CLI::App*> chain = {root};
  while (!chain.back()->get_subcommands().empty()) {
    chain.push_back(chain.back()->get_subcommands().front());
  }
  return chain;
}

std::vector<std::string> subcommand_names(const CLI::App& command) {
  std::vector<std::string> names;
  const auto all = [](const CLI::App*) { return true; };
  for (const CLI::App* subcommand : command.get_subcommands(all)) {
    names.push_back(subcommand->get_name());
  }
  return names;
}

/// Of these commands: an option is known below the command that has it.
std::vector<std::string> option_names(const std::vector<const CLI::App*>& commands) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands) {
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

}  // namespace

std::string usage_error(const CLI::App* app, const CLI::Error& error) {
  std::string text = std::string(error.what()) + "\n";
  const std::vector<const CLI::App*> chain = chosen_commands(app);
  for (const std::string& word : app->remaining(true)) {
    const bool option = word.rfind("--", 0) == 0;
    const std::string name = word.substr(0, word.find('='));
    const auto nearest =
        nearest_name(name, option ? option_names(chain) : subcommand_names(*chain.back()));
    if (nearest) {
      text += fmt::format("'{}' is unknown; did you mean '{}'?\n", name, *nearest);
    } else if (!option && !subcommand_names(*chain.back()).empty()) {
      text += fmt::format("'{}' is no command of {}\n", name, chain.back()->get_name());
    }
  }
  std::string command;
  for (const CLI::App* part : chain) command += part->get_name() + " ";
  return text + fmt::format("Run {}--help for more information.\n", command);
}

}  // namespace imslam::app
