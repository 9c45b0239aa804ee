#pragma once

#include <string>
#include <vector>

#include "app/command.hpp"
#include "slam/plugins/routing/routing_solver.hpp"

namespace imslam::app {

// The parts of `imslam route`, one file each.
void add_route_solve(CLI::App& parent, Action& action, const CommonOptions& common);
void add_route_bench(CLI::App& parent, Action& action, const CommonOptions& common);
void add_route_variance(CLI::App& parent, Action& action, const CommonOptions& common);

/// "5,10,15" as numbers. Throws InputError(kUsage) naming the option.
std::vector<int> whole_numbers(const std::string& option, const std::string& text);
std::vector<double> positive_numbers(const std::string& option, const std::string& text);

/// Random instance number `index` of a seed: the same for every method and command.
routing::Instance numbered_instance(int cities, int seed, int index);

}  // namespace imslam::app
