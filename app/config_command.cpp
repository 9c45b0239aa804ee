#include <cstdio>

#include "app/command.hpp"
#include "app/settings.hpp"

namespace imslam::app {

void add_config_command(CLI::App& app, Action& action) {
  auto* config = app.add_subcommand("config", "Show or check the configuration");
  config->require_subcommand(1);
  auto layers = std::make_shared<ConfigLayers>();

  auto* dump = config->add_subcommand("dump", "Print every key with its value and its meaning");
  layers->add_options(*dump);
  dump->callback([&action, layers] {
    action = [layers] {
      Settings settings;
      layers->apply(settings);
      std::fputs(settings.config().to_yaml(true).c_str(), stdout);
      return ExitCode::kOk;
    };
  });

  auto* diff = config->add_subcommand("diff", "Print the keys that differ from the defaults");
  layers->add_options(*diff);
  diff->callback([&action, layers] {
    action = [layers] {
      Settings settings;
      layers->apply(settings);
      std::fputs(settings.config().changes().c_str(), stdout);
      return ExitCode::kOk;
    };
  });

  auto* validate =
      config->add_subcommand("validate", "Check a configuration and say nothing if good");
  layers->add_options(*validate);
  validate->callback([&action, layers] {
    action = [layers] {
      Settings settings;
      layers->apply(settings);
      return ExitCode::kOk;
    };
  });
}

}  // namespace imslam::app
