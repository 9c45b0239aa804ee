#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/simulation/texture.hpp"
#include "slam/training/layer_renderer.hpp"
#include "slam/training/layered_scene.hpp"
#include "slam/training/shape_bank.hpp"
#include "slam/training/triplet.hpp"

namespace imslam::training {

struct TripletOptions {
  SceneOptions scene;
  int seed = 1;
  std::string textures = "auto";  ///< as SimulationOptions::textures: auto, photos, procedural
  int texture_count = 160;        ///< drawn once; about 1 MB each
  int shape_count = 96;           ///< outlines of cut-outs, drawn once
  double softness = 1.0;  ///< mip levels of blur that the softest lens has; a quarter: the sharpest

  void describe(Config& config);
  void validate() const;
};

/// Endless synthetic training samples for the matcher: clean views with exact truth.
///
/// Sample i depends on the options and i alone: not on the samples before it, nor on threads. So
/// training resumes at any i. (With textures "auto" or "photos" it also depends on the photographs
/// that are installed: see description().)
class TripletGenerator {
 public:
  /// Makes the textures, in parallel (seconds). Throws InputError(kUsage) on bad options.
  explicit TripletGenerator(const TripletOptions& options);

  /// Thread-safe. `triplet` keeps its memory from one call to the next.
  void make(std::uint64_t index, Triplet& triplet) const;
  Triplet make(std::uint64_t index) const;

  /// Samples first, first + 1, ...; parallel.
  std::vector<Triplet> batch(std::uint64_t first, std::size_t count) const;

  /// The scene of a sample, for those who want to know more than the truth in the triplet.
  LayeredScene scene(std::uint64_t index) const;
  const ShapeBank& shapes() const { return shapes_; }

  /// Of the textures, e.g. "procedural" or "photos (231 files, sha256 ...)".
  const std::string& description() const { return description_; }

 private:
  TripletGenerator(const TripletOptions& options, const std::vector<simulation::Texture>& textures);

  TripletOptions options_;
  std::string description_;
  simulation::TexturePool pool_;
  ShapeBank shapes_;
  SceneStock stock_;
};

}  // namespace imslam::training
