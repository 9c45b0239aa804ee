#include "slam/training/triplet_generator.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "datasets/simulation/texture_bank.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/training/layer_truth.hpp"

namespace imslam::training {
namespace {

using simulation::Material;
using simulation::Texture;

/// Streams of Random(seed).
enum : std::uint64_t { kTextureStream, kShapeStream, kSampleStream };
/// Streams of a sample.
enum : std::uint64_t { kSceneStream, kLensStream };

const std::vector<std::string> kTextureModes{"auto", "photos", "procedural"};

/// Posters are whole photographs (drawn posters where there are none); the others are mixtures.
Material draw_kind(Random& random) {
  constexpr std::array kKinds{Material::kPlaster, Material::kBrick,    Material::kPlanks,
                              Material::kTiles,   Material::kCarpet,   Material::kBark,
                              Material::kGround,  Material::kConcrete, Material::kAsphalt,
                              Material::kGrass,   Material::kLeaf,     Material::kRock,
                              Material::kFacade,  Material::kBooks,    Material::kDoor,
                              Material::kFabric,  Material::kMetal,    Material::kCeiling};
  if (random.chance(0.4)) return Material::kPoster;
  return kKinds[static_cast<std::size_t>(random.integer(0, std::int64_t{kKinds.size()} - 1))];
}

std::vector<Texture> make_textures(const TripletOptions& options, const Random& random) {
  options.validate();
  const simulation::TextureBank bank(options.textures);
  std::vector<std::optional<Texture>> made(static_cast<std::size_t>(options.texture_count));
  parallel_for(made.size(), [&](std::size_t i) {
    Random own = random.fork(i);
    const Material kind = draw_kind(own);
    made[i] = bank.make(kind, own.fork(0));
  });
  std::vector<Texture> textures;
  textures.reserve(made.size());
  for (std::optional<Texture>& texture : made) textures.push_back(std::move(*texture));
  return textures;
}

/// Looks at the first mip level: what a pixel sees is rarely finer.
TextureFacts facts_of(const Texture& texture) {
  TextureFacts facts;
  facts.size = texture.size();
  facts.mean = double{texture.mean()};
  const auto fine = static_cast<std::size_t>(texture.size());
  const std::size_t size = fine / 2;
  if (size < 2) return facts;
  const std::uint8_t* level = texture.pixels() + fine * fine;
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i + size < size * size; ++i) {
    sum += std::abs(level[i + 1] - level[i]) + std::abs(level[i + size] - level[i]);
    squares += std::pow(level[i] / 255.0 - facts.mean, 2);
  }
  facts.deviation = std::sqrt(squares / static_cast<double>(size * (size - 1)));
  facts.detail = sum / (2.0 * 255.0 * static_cast<double>(size * (size - 1)));
  return facts;
}

Random stream(int seed, std::uint64_t which) {
  return Random(static_cast<std::uint64_t>(seed)).fork(which);
}

LayerImages project(const LayeredScene& scene, const lie::SE3d& T_camera_left0) {
  LayerImages images;
  for (const Layer& layer : scene.layers)
    images.push_back(project_layer(layer, scene.camera, T_camera_left0));
  return images;
}

LayerImages project_after_motion(const LayeredScene& scene) {
  LayerImages images;
  for (const Layer& layer : scene.layers)
    images.push_back(project_layer(layer, scene.camera, scene.T_left1_layer(layer)));
  return images;
}

}  // namespace

void TripletOptions::describe(Config& config) {
  config.section("scene", scene);
  config.field("seed", seed, "of all samples");
  config.field("textures", textures, kTextureModes, "where textures come from");
  config.field("texture_count", texture_count, "textures to choose from, about 1 MB each");
  config.field("shape_count", shape_count, "outlines of cut-outs to choose from");
  config.field("softness", softness,
               "blur of the softest lens [mip levels], four times the sharpest one's");
}

void TripletOptions::validate() const {
  scene.validate();
  const auto within = [](const char* key, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw InputError(fmt::format("{}: expected {} to {}, got {}", key, low, high, value),
                     ExitCode::kUsage);
  };
  within("texture_count", texture_count, 1, 2000);
  within("shape_count", shape_count, 1, 10000);
  within("softness", softness, 0.0, 3.0);
}

TripletGenerator::TripletGenerator(const TripletOptions& options)
    : TripletGenerator(options, make_textures(options, stream(options.seed, kTextureStream))) {}

TripletGenerator::TripletGenerator(const TripletOptions& options,
                                   const std::vector<Texture>& textures)
    : options_(options),
      description_(simulation::TextureBank(options.textures).description()),
      pool_(textures),
      shapes_(static_cast<std::size_t>(options.shape_count), stream(options.seed, kShapeStream)) {
  for (const Texture& texture : textures) stock_.textures.push_back(facts_of(texture));
  stock_.shapes = shapes_.size();
}

LayeredScene TripletGenerator::scene(std::uint64_t index) const {
  return draw_scene(options_.scene, stock_,
                    stream(options_.seed, kSampleStream).fork(index).fork(kSceneStream));
}

void TripletGenerator::make(std::uint64_t index, Triplet& triplet) const {
  const LayeredScene drawn = scene(index);
  Random lens = stream(options_.seed, kSampleStream).fork(index).fork(kLensStream);
  const auto softness = static_cast<float>(options_.softness * lens.uniform(0.25, 1.0));
  SeenScene left0{project(drawn, {}), {}};
  SeenScene right0{project(drawn, drawn.T_right0_left0()), {}};
  SeenScene left1{project_after_motion(drawn), {}};
  const LayerRenderer renderer(pool_, shapes_);
  // The triplet's own memory serves as canvas.
  left0.view.grey.swap(triplet.left0);
  right0.view.grey.swap(triplet.right0);
  left1.view.grey.swap(triplet.left1);
  for (SeenScene* seen : {&left0, &right0, &left1})
    renderer.render(drawn, seen->images, softness, seen->view);
  triplet.camera = drawn.camera;
  triplet.T_left1_left0 = drawn.T_left1_left0;
  write_disparity(drawn, shapes_, left0, right0, triplet);
  write_flow(drawn, shapes_, left0, left1, triplet);
  triplet.left0.swap(left0.view.grey);
  triplet.right0.swap(right0.view.grey);
  triplet.left1.swap(left1.view.grey);
}

Triplet TripletGenerator::make(std::uint64_t index) const {
  Triplet triplet;
  make(index, triplet);
  return triplet;
}

std::vector<Triplet> TripletGenerator::batch(std::uint64_t first, std::size_t count) const {
  std::vector<Triplet> triplets(count);
  parallel_for(count, [&](std::size_t i) { make(first + i, triplets[i]); });
  return triplets;
}

}  // namespace imslam::training
