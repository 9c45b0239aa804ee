#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slam/plugins/routing/instance.hpp"

namespace imslam::routing {

/// Who visits what, in which order.
struct Solution {
  std::vector<std::vector<int>> tours;  ///< one per agent; the depot, where it starts, is left out
  std::vector<double> lengths;          ///< of the closed tours; 0 for an agent that stays at home

  double longest() const;
  double total() const;
};

/// With the lengths by Instance::distance. Throws ContractError unless every city but the depot is
/// in exactly one tour.
Solution measured(const Instance& instance, std::vector<std::vector<int>> tours);

/// {"tours": [[city, ...], ...], "lengths": [...], "depot": ..., ...}
std::string tours_json(const Instance& instance, const Solution& solution);
/// agent, stop, city, x, y, length so far; the depot at both ends. No x, y without coordinates.
std::string tours_csv(const Instance& instance, const Solution& solution);
/// A picture; empty without coordinates.
std::string tours_svg(const Instance& instance, const Solution& solution);

/// Reads what tours_json() writes; `name` stands in errors. Throws InputError.
Solution read_tours_json(const std::string& name, const std::string& text);

/// tours.json, tours.csv and tours.svg in a folder that it makes. Throws InputError(kOutput).
void write_solution(const std::filesystem::path& folder,
                    const Instance& instance,
                    const Solution& solution);

}  // namespace imslam::routing
