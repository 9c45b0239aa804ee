#include <algorithm>

#include "datasets/simulation/world.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::simulation {
namespace {

constexpr int kMostTaps = 5;  ///< samples along the long axis of a pixel's footprint
constexpr std::uint32_t kSkySurface = 0xFFFFFFFFU;
constexpr float kSkyScale = 0.25F;
constexpr float kHorizonLight = 0.95F;
constexpr int kWeightBits = 10;  ///< of bilinear weights: 1/1024 texel
constexpr int kOne = 1 << kWeightBits;

[[gnu::always_inline]] inline Floats dot(const Floats3& a, const Floats3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline Floats3 times(const Floats& s, const Floats3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
[[gnu::always_inline]] inline Floats3 minus(const Floats3& a, const Floats3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Floats most(const Floats& a, const Floats& b) {
  return a > b ? a : b;
}
[[gnu::always_inline]] inline Floats least(const Floats& a, const Floats& b) {
  return a < b ? a : b;
}
[[gnu::always_inline]] inline Floats absolute(const Floats& a) { return a < 0.0F ? -a : a; }
[[gnu::always_inline]] inline Floats to_floats(const Ints& a) {
  return __builtin_convertvector(a, Floats);
}
[[gnu::always_inline]] inline Ints to_ints(const Floats& a) {
  return __builtin_convertvector(a, Ints);
}
[[gnu::always_inline]] inline Ints floor_to_ints(const Floats& a) {
  const Ints truncated = to_ints(a);
  return truncated + (a < to_floats(truncated));  // a comparison that holds is -1
}
[[gnu::always_inline]] inline Floats all(float value) { return Floats{} + value; }

/// log2 from the exponent bits and a parabola for the mantissa: within 0.01.
[[gnu::always_inline]] inline Floats fast_log2(const Floats& x) {
  Ints bits;
  std::memcpy(&bits, &x, sizeof bits);
  const Floats exponent = to_floats((bits >> 23) - 128);
  bits = (bits & 0x007FFFFF) | 0x3F800000;
  Floats mantissa;
  std::memcpy(&mantissa, &bits, sizeof mantissa);
  return exponent + (-0.33582878F * mantissa + 2.0F) * mantissa - 0.65871759F;
}

/// R^T a
[[gnu::always_inline]] inline Floats3 rotated_back(const Floats (&R)[9], const Floats3& a) {
  return {R[0] * a.x + R[1] * a.y + R[2] * a.z, R[3] * a.x + R[4] * a.y + R[5] * a.z,
          R[6] * a.x + R[7] * a.y + R[8] * a.z};
}

}  // namespace

/// What World knows about the sixteen hits, lane by lane.
struct Gathered {
  Floats3 origin, normal, grad_u, grad_v, grad_light;  ///< of the facets
  Floats u0, v0, light0;
  Floats R[9];      ///< of the placements, column major
  Floats3 from;     ///< from the object's origin to the camera [m], world
  Floats scale;     ///< of the placements
  Ints sky;         ///< -1: nothing was hit
  Ints instanced;   ///< -1: hit an instance
  Ints size;        ///< of the texture
  Ints last_level;  ///< of the texture
  Ints first;       ///< row of the texture in the pool's starts
  bool any_sky, any_instance;
};

namespace {

/// Where a footprint lies in its texture, and how large it is.
struct Footprint {
  Floats u, v;    ///< [tiles]
  Floats du, dv;  ///< from one tap to the next [tiles]
  Floats lod;
  Ints taps;
  int most_taps;
};

[[gnu::always_inline]] inline Floats bilinear(const std::uint8_t* texels,
                                              const Ints& start,
                                              const Ints& size,
                                              const Floats& u,
                                              const Floats& v) {
  const Floats scale = to_floats(size << kWeightBits);
  const Ints x = floor_to_ints(u * scale) - kOne / 2;  // texel centres lie at half integers
  const Ints y = floor_to_ints(v * scale) - kOne / 2;
  const Ints fx = x & (kOne - 1);
  const Ints fy = y & (kOne - 1);
  const Ints column = (x >> kWeightBits) & (size - 1);
  const Ints row = (y >> kWeightBits) & (size - 1);
  const Ints upper = start + row * (size + 1) + column;
  const Ints lower = upper + size + 1;
  Ints above;
  Ints below;
  for (std::size_t i = 0; i < kLanes; ++i) {
    std::uint16_t pair;
    std::memcpy(&pair, texels + upper[i], sizeof pair);
    above[i] = pair;
    std::memcpy(&pair, texels + lower[i], sizeof pair);
    below[i] = pair;
  }
  const Ints top = (above & 255) * (kOne - fx) + (above >> 8) * fx;
  const Ints bottom = (below & 255) * (kOne - fx) + (below >> 8) * fx;
  constexpr float kUnit = 1.0F / (255.0F * kOne * kOne);
  return to_floats(top * (kOne - fy) + bottom * fy) * kUnit;
}

/// Mean over the footprint: mip level from the short axis, several taps along the long one.
[[gnu::always_inline]] inline Floats sampled(const TexturePool& pool,
                                             const Gathered& g,
                                             const Footprint& f,
                                             bool blend_levels) {
  const Floats clamped = least(most(f.lod, all(0.0F)), to_floats(g.last_level));
  const Ints fine = to_ints(clamped);
  const Ints coarse = fine < g.last_level ? fine + 1 : fine;
  const Floats share = clamped - to_floats(fine);
  Ints fine_start;
  Ints coarse_start;
  bool blend = false;
  for (std::size_t i = 0; i < kLanes; ++i) {
    fine_start[i] = pool.starts()[g.first[i] + fine[i]];
    coarse_start[i] = pool.starts()[g.first[i] + coarse[i]];
    blend = blend || share[i] > 0.0F;
  }
  blend = blend && blend_levels;
  Floats sum = {};
  for (int i = 0; i < f.most_taps; ++i) {
    const Floats offset = static_cast<float>(i) - 0.5F * to_floats(f.taps - 1);
    const Floats u = f.u + offset * f.du;
    const Floats v = f.v + offset * f.dv;
    Floats value = bilinear(pool.texels(), fine_start, g.size >> fine, u, v);
    if (blend) {
      const Floats other = bilinear(pool.texels(), coarse_start, g.size >> coarse, u, v);
      value += share * (other - value);
    }
    sum += f.taps > i ? value : Floats{};
  }
  return sum / to_floats(f.taps);
}

}  // namespace

/// Radiance and distance along the lanes' rays.
IMSLAM_FOR_EACH_PROCESSOR void shade(const Gathered& g,
                                     const TexturePool& pool,
                                     const Lighting& light,
                                     const RayPacket& rays,
                                     float footprint,
                                     SeenPacket& seen) {
  // Everything in the object's frame, lengths divided by its scale.
  Floats3 from = g.from;
  Floats3 d = rays.direction;
  Floats3 d_column = times(all(footprint), rays.d_column);
  Floats3 d_row = times(all(footprint), rays.d_row);
  Floats3 to_sun{all(light.to_sun.x()), all(light.to_sun.y()), all(light.to_sun.z())};
  if (g.any_instance) {
    from = times(1.0F / g.scale, rotated_back(g.R, from));
    d = rotated_back(g.R, d);
    d_column = rotated_back(g.R, d_column);
    d_row = rotated_back(g.R, d_row);
    to_sun = rotated_back(g.R, to_sun);
  }
  const Floats slope = dot(g.normal, d);
  const Floats steep = absolute(slope) < 1e-6F ? (slope < 0.0F ? all(-1e-6F) : all(1e-6F)) : slope;
  const Floats3 from_facet = minus(from, g.origin);
  const Floats t = most(all(0.0F), -dot(g.normal, from_facet) / steep);
  const Floats3 p{from_facet.x + t * d.x, from_facet.y + t * d.y, from_facet.z + t * d.z};

  // Where the neighbouring pixels' rays meet the same plane.
  const Floats slide_column = dot(g.normal, d_column) / steep;
  const Floats slide_row = dot(g.normal, d_row) / steep;
  const Floats3 p_column = times(t, minus(d_column, times(slide_column, d)));
  const Floats3 p_row = times(t, minus(d_row, times(slide_row, d)));
  const Floats size = to_floats(g.size);
  Floats du_column = dot(g.grad_u, p_column);
  Floats dv_column = dot(g.grad_v, p_column);
  Floats du_row = dot(g.grad_u, p_row);
  Floats dv_row = dot(g.grad_v, p_row);
  const Floats column_sq = (du_column * du_column + dv_column * dv_column) * (size * size);
  const Floats row_sq = (du_row * du_row + dv_row * dv_row) * (size * size);
  const Floats area = absolute(du_column * dv_row - dv_column * du_row) * (size * size);
  const Ints column_longer = column_sq > row_sq;
  const Floats longest_sq = column_longer ? column_sq : row_sq;

  // As many taps as the longer side is longer than the shorter one, or than a texel.
  Footprint f;
  f.taps = Ints{} + 1;
  for (int k = 2; k <= kMostTaps; ++k) {
    const float bound = static_cast<float>(k) - 0.5F;
    f.taps -= (longest_sq >= bound * bound) & (longest_sq >= bound * area);
  }
  f.u = g.u0 + dot(g.grad_u, p);
  f.v = g.v0 + dot(g.grad_v, p);
  const Floats taps = to_floats(f.taps);
  Floats step_sq = longest_sq / (taps * taps);
  Floats gain = most(all(0.02F), g.light0 + dot(g.grad_light, p));
  Floats offset = {};
  Floats distance = t * g.scale;
  if (g.any_instance) {
    const Floats facing = dot(g.normal, to_sun);
    // Leaves and thin things let some light through, so both sides count.
    const Floats lit = light.ambient + light.sun * (facing > 0.0F ? facing : -0.35F * facing);
    gain = g.instanced ? gain * lit : gain;
  }
  if (g.any_sky) {
    // Clouds on a flat layer; near the horizon they fade into haze.
    const Floats up = most(rays.direction.z, all(0.02F));
    const Floats per_pixel = kSkyScale / (up * up) * size;
    f.u = g.sky ? kSkyScale * rays.direction.x / up : f.u;
    f.v = g.sky ? kSkyScale * rays.direction.y / up : f.v;
    f.taps = g.sky ? Ints{} + 1 : f.taps;
    step_sq = g.sky ? dot(rays.d_column, rays.d_column) * per_pixel * per_pixel : step_sq;
    const Floats haze = least(all(1.0F), 5.0F * up);
    gain = g.sky ? haze : gain;
    offset = g.sky ? (1.0F - haze) * kHorizonLight : offset;
    distance = g.sky ? all(std::numeric_limits<float>::infinity()) : distance;
  }
  f.du = (column_longer ? du_column : du_row) / taps;
  f.dv = (column_longer ? dv_column : dv_row) / taps;
  f.lod = 0.5F * fast_log2(most(step_sq, all(0.0625F)));
  f.most_taps = 1;
  for (std::size_t i = 0; i < kLanes; ++i) f.most_taps = std::max(f.most_taps, int{f.taps[i]});
  // Samples that are averaged anyway do without blending levels.
  const bool blend_levels = footprint >= 1.0F;
  if (!blend_levels) f.lod = to_floats(to_ints(most(f.lod, all(0.0F)) + 0.5F));
  seen.radiance = sampled(pool, g, f, blend_levels) * gain + offset;
  seen.distance = distance;
}

void World::look(const Eigen::Vector3f& origin,
                 const RayPacket& rays,
                 const Hit* hits,
                 float footprint,
                 SeenPacket& seen) const {
  static const Facet kNoFacet = [] {
    Facet facet;
    facet.normal = Eigen::Vector3f::UnitZ();
    facet.origin = facet.grad_u = facet.grad_v = facet.grad_light = Eigen::Vector3f::Zero();
    return facet;
  }();
  Gathered g;
  g.any_sky = false;
  g.any_instance = false;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool sky = i >= rays.count || hits[i].empty();
    const std::uint32_t instance = sky ? 0 : hits[i].instance;
    const Placement& placement = placements_[instance];
    const Facet& facet = sky ? kNoFacet : facets_[placement.mesh][hits[i].triangle];
    const auto put = [i](Floats3& lanes, const Eigen::Vector3f& value) {
      lanes.x[i] = value.x();
      lanes.y[i] = value.y();
      lanes.z[i] = value.z();
    };
    put(g.origin, facet.origin);
    put(g.normal, facet.normal);
    put(g.grad_u, facet.grad_u);
    put(g.grad_v, facet.grad_v);
    put(g.grad_light, facet.grad_light);
    put(g.from, origin - placement.position);
    g.u0[i] = facet.u0;
    g.v0[i] = facet.v0;
    g.light0[i] = facet.light0;
    g.scale[i] = placement.scale;
    g.sky[i] = sky ? -1 : 0;
    g.instanced[i] = instance != 0 ? -1 : 0;
    g.any_sky = g.any_sky || sky;
    g.any_instance = g.any_instance || instance != 0;
    const std::size_t texture = sky ? scene_.sky_texture : facet.texture;
    g.size[i] = pool_.size(texture);
    g.last_level[i] = pool_.last_level(texture);
    g.first[i] = static_cast<std::int32_t>(texture * TexturePool::kMostLevels);
    seen.surface[i] = sky ? kSkySurface : (instance * 0x9E3779B1U) ^ (facet.surface * 0x85EBCA77U);
    seen.instance[i] = instance;
  }
  if (g.any_instance) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const float* R = placements_[seen.instance[i]].R_world_object.data();
      for (std::size_t k = 0; k < 9; ++k) g.R[k][i] = R[k];
    }
  }
  shade(g, pool_, scene_.lighting, rays, footprint, seen);
}

}  // namespace imslam::simulation
