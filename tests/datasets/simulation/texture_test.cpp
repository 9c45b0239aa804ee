#include "datasets/simulation/texture.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/simulation/materials.hpp"
#include "datasets/simulation/texture_bank.hpp"
#include "datasets/simulation/texture_pool.hpp"
#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

std::vector<std::uint8_t> ramp(int size) {
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < size * size; ++i)
    pixels.push_back(static_cast<std::uint8_t>(10 * (i % size)));
  return pixels;
}

TEST(Texture, GivesTheTexelAtItsCentreAndTheMeanBetweenTwo) {
  const Texture texture(8, ramp(8));
  EXPECT_NEAR(255 * texture.sample(3.5F / 8, 0.5F / 8, 0), 30.0, 1e-3);
  EXPECT_NEAR(255 * texture.sample(4.0F / 8, 0.5F / 8, 0), 35.0, 1e-3);
  EXPECT_NEAR(255 * texture.sample(3.75F / 8, 0.2F, 0), 32.5, 1e-2);
}

TEST(Texture, RepeatsInBothDirections) {
  const Texture texture(8, ramp(8));
  for (const float u : {0.07F, 0.51F, 0.93F}) {
    EXPECT_NEAR(texture.sample(u, 0.3F, 0), texture.sample(u + 3.0F, 0.3F - 2.0F, 0), 1e-4);
    EXPECT_NEAR(texture.sample(u, 0.3F, 1.5F), texture.sample(u - 5.0F, 0.3F + 1.0F, 1.5F), 1e-4);
  }
}

TEST(Texture, CoarsestLevelIsTheMean) {
  const Texture texture(8, ramp(8));
  EXPECT_NEAR(255 * texture.sample(0.1F, 0.8F, 20), 35.0, 1.0);
  EXPECT_NEAR(texture.mean(), texture.sample(0.4F, 0.4F, 3), 1e-6);
}

TEST(Texture, RejectsASizeThatIsNoPowerOfTwo) {
  EXPECT_THROW(Texture(6, std::vector<std::uint8_t>(36)), ContractError);
  EXPECT_THROW(Texture(8, std::vector<std::uint8_t>(36)), ContractError);
}

// A front end lives on contrast: every material that covers large surfaces must have some, and
// must join itself without a seam.
TEST(TexturePool, RepeatsTheFirstRowAndColumnOfEachLevelBehindTheLast) {
  Random random(5);
  const Texture first = draw_material(Material::kBrick, random.fork(1));
  const Texture second(2, {10, 20, 30, 40});
  const TexturePool pool({first, second});
  ASSERT_EQ(pool.size(1), 2);
  ASSERT_EQ(pool.last_level(1), 1);
  const std::int32_t* starts = pool.starts() + TexturePool::kMostLevels;
  const std::uint8_t* fine = pool.texels() + starts[0];
  EXPECT_EQ(std::vector<int>(fine, fine + 9),
            std::vector<int>({10, 20, 10, 30, 40, 30, 10, 20, 10}));
  const std::uint8_t* coarse = pool.texels() + starts[1];
  EXPECT_EQ(std::vector<int>(coarse, coarse + 4), std::vector<int>({25, 25, 25, 25}));
}

TEST(Materials, HaveContrastAndNoSeam) {
  for (const Material material :
       {Material::kPlaster, Material::kBrick, Material::kPlanks, Material::kTiles,
        Material::kCarpet, Material::kConcrete, Material::kAsphalt, Material::kBark,
        Material::kGround, Material::kLeaf, Material::kRock, Material::kFacade, Material::kCeiling,
        Material::kFabric}) {
    const Texture texture = draw_material(material, Random(11));
    const int n = texture.size();
    double sum = 0.0;
    double squares = 0.0;
    double seam = 0.0;
    double inside = 0.0;
    const auto at = [&](int y, int x) { return static_cast<double>(texture.pixels()[y * n + x]); };
    for (int y = 0; y < n; ++y) {
      seam += std::abs(at(y, 0) - at(y, n - 1));
      inside += std::abs(at(y, 101) - at(y, 100)) + std::abs(at(y, 301) - at(y, 300));
      for (int x = 0; x < n; ++x) {
        sum += at(y, x);
        squares += at(y, x) * at(y, x);
      }
    }
    const double mean = sum / (n * n);
    EXPECT_GT(std::sqrt(squares / (n * n) - mean * mean), 8.0) << static_cast<int>(material);
    EXPECT_GT(mean, 25.0) << static_cast<int>(material);
    // Joints of bricks may lie on the seam: allow a strong but not a systematic difference.
    EXPECT_LT(seam / n, 2.0 * inside / (2 * n) + 40.0) << static_cast<int>(material);
  }
}

TEST(Materials, DependOnTheSeedOnly) {
  const Texture a = draw_material(Material::kPoster, Random(3));
  const Texture b = draw_material(Material::kPoster, Random(3));
  const Texture c = draw_material(Material::kPoster, Random(4));
  const auto bytes = static_cast<std::size_t>(a.size() * a.size());
  EXPECT_TRUE(std::equal(a.pixels(), a.pixels() + bytes, b.pixels()));
  EXPECT_FALSE(std::equal(a.pixels(), a.pixels() + bytes, c.pixels()));
}

TEST(TextureBank, ProceduralNeedsNoFiles) {
  EXPECT_EQ(TextureBank("procedural").description(), "procedural");
}

}  // namespace
}  // namespace imslam::simulation
