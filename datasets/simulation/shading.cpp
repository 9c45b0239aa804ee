#include "datasets/simulation/shading.hpp"

#include <limits>

#include "datasets/simulation/lanes.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::simulation {
namespace {

constexpr int kMostTaps = 5;            ///< samples along the long axis of a pixel's footprint
constexpr float kFlattest = 1e-6F;      ///< sine of the angle between a ray and a facet
constexpr float kDarkest = 0.02F;       ///< light that falls on anything
constexpr float kShineThrough = 0.35F;  ///< share of the sun that leaves let through
constexpr float kSkyScale = 0.25F;
constexpr float kHorizonLight = 0.95F;

/// Rays, their changes from pixel to pixel and the sun in the frame of what they hit, lengths
/// divided by its scale.
struct ObjectRays {
  Floats3 from, direction, d_column, d_row, to_sun;
};

/// Where the rays meet the planes of their facets, as seen from the facets' origins.
struct PlanePoints {
  Floats t;  ///< along the ray
  Floats3 p;
  Floats3 p_column, p_row;  ///< changes to the next pixel's ray
};

/// radiance = mean of the texture over the footprint * gain + offset
struct Shades {
  Footprints footprint;
  Floats gain, offset, distance;
};

[[gnu::always_inline]] inline ObjectRays in_object_frame(const HitLanes& hits,
                                                         const Lighting& light,
                                                         const RayPacket& rays,
                                                         float footprint) {
  ObjectRays r;
  r.from = hits.from;
  r.direction = rays.direction;
  r.d_column = times(all(footprint), rays.d_column);
  r.d_row = times(all(footprint), rays.d_row);
  r.to_sun = {all(light.to_sun.x()), all(light.to_sun.y()), all(light.to_sun.z())};
  if (hits.any_instance) {
    r.from = times(1.0F / hits.scale, rotated_back(hits.R_world_object, r.from));
    r.direction = rotated_back(hits.R_world_object, r.direction);
    r.d_column = rotated_back(hits.R_world_object, r.d_column);
    r.d_row = rotated_back(hits.R_world_object, r.d_row);
    r.to_sun = rotated_back(hits.R_world_object, r.to_sun);
  }
  return r;
}

/// n . (from + t d) = 0, and its derivative with respect to d.
[[gnu::always_inline]] inline PlanePoints meet_planes(const HitLanes& hits, const ObjectRays& r) {
  const Floats slope = dot(hits.normal, r.direction);
  const Floats least_steep = slope < 0.0F ? all(-kFlattest) : all(kFlattest);
  const Floats steep = absolute(slope) < kFlattest ? least_steep : slope;
  const Floats3 from_facet = minus(r.from, hits.origin);
  PlanePoints m;
  m.t = most(all(0.0F), -dot(hits.normal, from_facet) / steep);
  m.p = plus(from_facet, times(m.t, r.direction));
  const Floats slide_column = dot(hits.normal, r.d_column) / steep;
  const Floats slide_row = dot(hits.normal, r.d_row) / steep;
  m.p_column = times(m.t, minus(r.d_column, times(slide_column, r.direction)));
  m.p_row = times(m.t, minus(r.d_row, times(slide_row, r.direction)));
  return m;
}

/// Level whose texels are as wide as the root of `width_sq` [texels^2]; down to a quarter.
[[gnu::always_inline]] inline Floats level_of(const Floats& width_sq) {
  return 0.5F * fast_log2(most(width_sq, all(0.0625F)));
}

/// A pixel sees a parallelogram: as many taps along its longer side as that is longer than the
/// parallelogram is wide, or than a texel.
[[gnu::always_inline]] inline Footprints footprints_on(const HitLanes& hits, const PlanePoints& m) {
  const Floats du_column = dot(hits.grad_u, m.p_column);
  const Floats dv_column = dot(hits.grad_v, m.p_column);
  const Floats du_row = dot(hits.grad_u, m.p_row);
  const Floats dv_row = dot(hits.grad_v, m.p_row);
  const Floats size = to_floats(hits.texture.size);
  const Floats column_sq = (du_column * du_column + dv_column * dv_column) * (size * size);
  const Floats row_sq = (du_row * du_row + dv_row * dv_row) * (size * size);
  const Floats area = absolute(du_column * dv_row - dv_column * du_row) * (size * size);
  const Ints column_longer = column_sq > row_sq;
  const Floats longest_sq = column_longer ? column_sq : row_sq;

  Footprints f;
  f.taps = Ints{} + 1;
  for (int k = 2; k <= kMostTaps; ++k) {
    const float bound = static_cast<float>(k) - 0.5F;
    f.taps -= (longest_sq >= bound * bound) & (longest_sq >= bound * area);
  }
  const Floats taps = to_floats(f.taps);
  f.u = hits.u0 + dot(hits.grad_u, m.p);
  f.v = hits.v0 + dot(hits.grad_v, m.p);
  f.du = (column_longer ? du_column : du_row) / taps;
  f.dv = (column_longer ? dv_column : dv_row) / taps;
  f.lod = level_of(longest_sq / (taps * taps));
  return f;
}

/// Baked light, for instances times that of the sky and the sun.
[[gnu::always_inline]] inline Floats light_on(const HitLanes& hits,
                                              const Lighting& light,
                                              const PlanePoints& m,
                                              const Floats3& to_sun) {
  const Floats baked = most(all(kDarkest), hits.light0 + dot(hits.grad_light, m.p));
  if (!hits.any_instance) return baked;
  const Floats facing = dot(hits.normal, to_sun);
  const Floats sun = facing > 0.0F ? facing : -kShineThrough * facing;
  return hits.instanced ? baked * (light.ambient + light.sun * sun) : baked;
}

/// Clouds on a flat layer where nothing was hit; near the horizon they fade into haze.
[[gnu::always_inline]] inline void show_sky(const HitLanes& hits,
                                            const RayPacket& rays,
                                            Shades& s) {
  const Floats3& d = rays.direction;
  const Floats up = most(d.z, all(0.02F));
  const Floats per_pixel = kSkyScale / (up * up) * to_floats(hits.texture.size);
  Footprints& f = s.footprint;
  f.u = hits.sky ? kSkyScale * d.x / up : f.u;
  f.v = hits.sky ? kSkyScale * d.y / up : f.v;
  f.taps = hits.sky ? Ints{} + 1 : f.taps;
  const Floats sky_lod = level_of(dot(rays.d_column, rays.d_column) * per_pixel * per_pixel);
  f.lod = hits.sky ? sky_lod : f.lod;
  const Floats haze = least(all(1.0F), 5.0F * up);
  s.gain = hits.sky ? haze : s.gain;
  s.offset = hits.sky ? (1.0F - haze) * kHorizonLight : s.offset;
  s.distance = hits.sky ? all(std::numeric_limits<float>::infinity()) : s.distance;
}

}  // namespace

IMSLAM_FOR_EACH_PROCESSOR void shade(const HitLanes& hits,
                                     const TexturePool& pool,
                                     const Lighting& light,
                                     const RayPacket& rays,
                                     float footprint,
                                     SeenPacket& seen) {
  const ObjectRays r = in_object_frame(hits, light, rays, footprint);
  const PlanePoints m = meet_planes(hits, r);
  Shades s;
  s.footprint = footprints_on(hits, m);
  s.gain = light_on(hits, light, m, r.to_sun);
  s.offset = Floats{};
  s.distance = m.t * hits.scale;
  if (hits.any_sky) show_sky(hits, rays, s);
  // Samples that are averaged anyway do without blending levels.
  Floats& lod = s.footprint.lod;
  if (footprint < 1.0F) lod = to_floats(to_ints(most(lod, all(0.0F)) + 0.5F));
  Floats texture;
  pool.sample(hits.texture, s.footprint, texture);
  seen.radiance = texture * s.gain + s.offset;
  seen.distance = s.distance;
}

}  // namespace imslam::simulation
