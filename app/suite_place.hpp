#pragma once

#include <filesystem>
#include <string>

#include "app/command.hpp"
#include "slam/base/process_group.hpp"
#include "slam/system/suite_file.hpp"

namespace imslam::app {

/// Where the sequences of a suite are: `root` (--root) before the environment's IMSLAM_SUITE_ROOT
/// before the file's; empty: none is given.
std::filesystem::path given_root(const std::string& root, const system::Suite& suite);

/// The same; throws InputError(kUsage) if none is given, (kData) if there is no such folder.
/// `suite_name`: as it was asked for.
std::filesystem::path choose_root(const std::string& root,
                                  const std::string& suite_name,
                                  const system::Suite& suite);

/// Each process of this machine gets its share of the processors, unless --threads says otherwise.
void share_processors(const CommonOptions& common, const ProcessOptions& processes);

}  // namespace imslam::app
