#pragma once

#include <CLI/App.hpp>
#include <string>

namespace imslam::app {

/// What the user reads after a command line that cannot be parsed: the error, the known name
/// nearest to each word that nobody asked for ("'rn' is unknown; did you mean 'run'?"), and where
/// the help is. A failure message of CLI::App; `app` is the root, after its parse.
std::string usage_error(const CLI::App* app, const CLI::Error& error);

}  // namespace imslam::app
