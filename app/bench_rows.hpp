#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "app/settings.hpp"
#include "slam/system/suite_bench.hpp"
#include "slam/system/suite_file.hpp"

namespace imslam::app {

/// What `imslam bench` is asked for.
struct BenchArguments {
  std::string suite;
  std::string root;
  std::string out;
  std::string variants = "vo,graph";
  std::string weights_vo;
  std::string front_end;
  int jobs = 1;
  bool force = false;
  bool list = false;
  ConfigLayers layers;
};

/// The rows of ours that arguments.variants names, with the runs that they are taken from in
/// `out`/<kind of run>/<sequence>. Throws InputError(kUsage) for unknown rows and wrong options.
std::vector<system::SuiteMethod> make_methods(const BenchArguments& arguments,
                                              const CommonOptions& common,
                                              const system::Suite& suite,
                                              const std::filesystem::path& out,
                                              bool show_progress);

}  // namespace imslam::app
