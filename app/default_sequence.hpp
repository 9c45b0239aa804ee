#pragma once

#include <filesystem>

namespace imslam::app {

/// The embedded default sequence: rendered once into `runs_root`/.default_sequence and used again
/// as long as it is complete and was made with the same options.
std::filesystem::path make_default_sequence(const std::filesystem::path& runs_root, bool quiet);

}  // namespace imslam::app
