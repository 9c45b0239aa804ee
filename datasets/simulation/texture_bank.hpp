#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/simulation/materials.hpp"
#include "slam/base/random.hpp"

namespace imslam::simulation {

/// Where the textures of a scene come from: drawn by the program, or cut from photographs of
/// installed packages (tools/texture_packages.txt), mixed with drawn ones.
class TextureBank {
 public:
  /// `mode` as in SimulationOptions::textures. Throws InputError(kData) for "photos" without any.
  explicit TextureBank(const std::string& mode);

  Texture make(Material material, Random random) const;

  /// e.g. "procedural" or "photos (231 files, sha256 of their names and sizes 0a1b...)".
  std::string description() const;

 private:
  std::vector<std::filesystem::path> photos_;
  std::vector<std::filesystem::path> grounds_;  ///< seamless pictures of soil, stone and snow
};

}  // namespace imslam::simulation
