#include "datasets/simulation/texture.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "datasets/simulation/materials.hpp"
#include "datasets/simulation/texture_bank.hpp"
#include "datasets/simulation/texture_pool.hpp"
#include "slam/base/error.hpp"
#include "tests/datasets/simulation/reference_shading.hpp"

namespace imslam::simulation {
namespace {

std::vector<std::uint8_t> ramp(int size) {
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < size * size; ++i)
    pixels.push_back(static_cast<std::uint8_t>(10 * (i % size)));
  return pixels;
}

/// One lane's answer.
double sampled(const Texture& texture, const Footprints& footprints) {
  const TexturePool pool({texture});
  TextureLanes lanes;
  for (std::size_t i = 0; i < kLanes; ++i) pool.aim(0, i, lanes);
  Floats means;
  pool.sample(lanes, footprints, means);
  return static_cast<double>(means[0]);
}

double sampled(const Texture& texture, float u, float v, float lod) {
  Footprints f{};
  f.u += u;
  f.v += v;
  f.lod += lod;
  f.taps += 1;
  return sampled(texture, f);
}

TEST(TexturePool, GivesTheTexelAtItsCentreAndTheMeanBetweenTwo) {
  const Texture texture(8, ramp(8));
  EXPECT_NEAR(255 * sampled(texture, 3.5F / 8, 0.5F / 8, 0), 30.0, 1e-3);
  EXPECT_NEAR(255 * sampled(texture, 4.0F / 8, 0.5F / 8, 0), 35.0, 1e-3);
  EXPECT_NEAR(255 * sampled(texture, 3.75F / 8, 0.2F, 0), 32.5, 1e-2);
}

TEST(TexturePool, RepeatsTexturesInBothDirections) {
  const Texture texture(8, ramp(8));
  for (const float u : {0.07F, 0.51F, 0.93F}) {
    EXPECT_NEAR(sampled(texture, u, 0.3F, 0), sampled(texture, u + 3.0F, 0.3F - 2.0F, 0), 1e-4);
    EXPECT_NEAR(sampled(texture, u, 0.3F, 1.5F), sampled(texture, u - 5.0F, 1.3F, 1.5F), 1e-4);
  }
}

TEST(TexturePool, CoarsestLevelIsTheMean) {
  const Texture texture(8, ramp(8));
  EXPECT_NEAR(255 * sampled(texture, 0.1F, 0.8F, 20), 35.0, 1.0);
  EXPECT_NEAR(texture.mean(), sampled(texture, 0.4F, 0.4F, 3), 1e-6);
}

TEST(TexturePool, TakesTheMeanOfTapsInARow) {
  const Texture texture(8, ramp(8));
  Footprints f{};
  f.u += 2.5F / 8;
  f.v += 0.5F / 8;
  f.du += 1.0F / 8;
  f.taps += 4;  // about texels 1, 2, 3 and 4, half way between centres
  EXPECT_NEAR(255 * sampled(texture, f), 20.0, 1e-3);
  f.taps -= 2;
  f.du += 1.0F / 8;
  EXPECT_NEAR(255 * sampled(texture, f), 20.0, 1e-3);
}

// Sixteen lanes with textures, places, levels and taps of their own.
TEST(TexturePool, LanesMatchTheSlowReference) {
  Random random(17);
  std::vector<Texture> textures;
  for (const Material material : {Material::kBrick, Material::kLeaf, Material::kPoster})
    textures.push_back(draw_material(material, random.fork(textures.size())));
  textures.emplace_back(1, std::vector<std::uint8_t>{77});
  const TexturePool pool(textures);
  const std::vector<ReferenceTexture> references(textures.begin(), textures.end());
  for (int round = 0; round < 100; ++round) {
    TextureLanes lanes;
    Footprints f;
    std::array<std::size_t, kLanes> chosen;
    for (std::size_t i = 0; i < kLanes; ++i) {
      chosen[i] = static_cast<std::size_t>(random.uniform(0.0, 4.0));
      pool.aim(chosen[i], i, lanes);
      f.u[i] = static_cast<float>(random.uniform(-3.0, 3.0));
      f.v[i] = static_cast<float>(random.uniform(-3.0, 3.0));
      f.du[i] = static_cast<float>(random.uniform(-0.01, 0.01));
      f.dv[i] = static_cast<float>(random.uniform(-0.01, 0.01));
      f.lod[i] = static_cast<float>(random.uniform(-2.0, 11.0));
      f.taps[i] = 1 + static_cast<int>(random.uniform(0.0, 5.0));
    }
    Floats means;
    pool.sample(lanes, f, means);
    for (std::size_t i = 0; i < kLanes; ++i) {
      double mean = 0.0;
      for (int tap = 0; tap < f.taps[i]; ++tap) {
        const double away = tap - 0.5 * (f.taps[i] - 1);
        mean += references[chosen[i]].sample(f.u[i] + away * static_cast<double>(f.du[i]),
                                             f.v[i] + away * static_cast<double>(f.dv[i]),
                                             static_cast<double>(f.lod[i])) /
                f.taps[i];
      }
      // Weights count 1/1024 of a texel.
      EXPECT_NEAR(means[i], mean, 2.0 / 1024) << round << " " << i;
    }
  }
}

TEST(Texture, RejectsASizeThatIsNoPowerOfTwo) {
  EXPECT_THROW(Texture(6, std::vector<std::uint8_t>(36)), ContractError);
  EXPECT_THROW(Texture(8, std::vector<std::uint8_t>(36)), ContractError);
}

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

// A front end lives on contrast: every material that covers large surfaces must have some, and
// must join itself without a seam.
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
