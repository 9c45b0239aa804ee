#pragma once

#include <filesystem>
#include <string>

namespace imslam::system {

/// Makes `runs_root`/<time>_<dataset>/ (local time, a number added if it exists), or takes `out` as
/// it is given. An existing non-empty `out` is refused unless it holds an earlier run and `force`.
/// Throws InputError(kOutput).
std::filesystem::path make_run_folder(const std::filesystem::path& runs_root,
                                      const std::string& dataset,
                                      const std::filesystem::path& out = {},
                                      bool force = false);

/// Points `folder`'s sibling `latest` to it; quietly does nothing where links are not possible.
void update_latest_link(const std::filesystem::path& folder);

/// Letters, digits, '-', '_' and '.' of `name`; everything else becomes '_'.
std::string safe_name(const std::string& name);

}  // namespace imslam::system
