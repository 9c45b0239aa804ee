#include "datasets/simulation/world.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "datasets/simulation/light_baker.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kMostTaps = 5;  ///< samples along the long axis of a pixel's footprint
constexpr std::uint32_t kSkySurface = 0xFFFFFFFFU;

/// log2 from the exponent bits and a parabola for the mantissa: within 0.01.
float fast_log2(float x) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  const auto exponent = static_cast<float>(static_cast<int>(bits >> 23U) - 128);
  bits = (bits & 0x007FFFFFU) | 0x3F800000U;
  float mantissa = 0.0F;
  std::memcpy(&mantissa, &bits, sizeof mantissa);
  return exponent + (-0.33582878F * mantissa + 2.0F) * mantissa - 0.65871759F;
}

/// The gradient g in the triangle's plane with g.e1 = d1, g.e2 = d2.
Vector3f plane_gradient(const Vector3f& e1, const Vector3f& e2, double d1, double d2) {
  const Eigen::Vector3d a = e1.cast<double>();
  const Eigen::Vector3d b = e2.cast<double>();
  const double aa = a.dot(a);
  const double ab = a.dot(b);
  const double bb = b.dot(b);
  const double determinant = aa * bb - ab * ab;
  if (determinant < 1e-30) return Vector3f::Zero();
  const double s = (bb * d1 - ab * d2) / determinant;
  const double t = (aa * d2 - ab * d1) / determinant;
  return (s * a + t * b).cast<float>();
}

std::vector<Facet> facets_of(const Mesh& mesh) {
  std::vector<Facet> facets;
  facets.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    const Vertex& a = mesh.vertices[triangle.a];
    const Vertex& b = mesh.vertices[triangle.b];
    const Vertex& c = mesh.vertices[triangle.c];
    const Vector3f e1 = b.position - a.position;
    const Vector3f e2 = c.position - a.position;
    Facet facet;
    facet.origin = a.position;
    facet.normal = e1.cast<double>().cross(e2.cast<double>()).normalized().cast<float>();
    facet.grad_u = plane_gradient(e1, e2, b.uv.x() - a.uv.x(), c.uv.x() - a.uv.x());
    facet.grad_v = plane_gradient(e1, e2, b.uv.y() - a.uv.y(), c.uv.y() - a.uv.y());
    facet.grad_light = plane_gradient(e1, e2, b.light - a.light, c.light - a.light);
    facet.u0 = a.uv.x();
    facet.v0 = a.uv.y();
    facet.light0 = a.light;
    facet.texture = triangle.texture;
    facet.surface = triangle.surface;
    facets.push_back(facet);
  }
  return facets;
}

struct TexturePoint {
  float u, v;                  ///< [tiles]
  float du_column, dv_column;  ///< change per pixel [tiles]
  float du_row, dv_row;
};

/// Mean over the footprint: mip level from the short axis, several taps along the long one. Samples
/// that are averaged anyway (`one_of_several`) do without blending levels.
float filtered(const Texture& texture, const TexturePoint& p, bool one_of_several) {
  const auto size = static_cast<float>(texture.size());
  const float column = p.du_column * p.du_column + p.dv_column * p.dv_column;
  const float row = p.du_row * p.du_row + p.dv_row * p.dv_row;
  const bool column_longer = column > row;
  const float longest = std::sqrt(std::max(column, row)) * size;
  const float area = std::abs(p.du_column * p.dv_row - p.dv_column * p.du_row) * size * size;
  const float shortest = std::max(area / std::max(longest, 1e-9F), 1.0F);
  const int taps = std::clamp(static_cast<int>(longest / shortest + 0.5F), 1, kMostTaps);
  const float level = fast_log2(std::max(longest / static_cast<float>(taps), 0.25F));
  const float lod =
      one_of_several ? static_cast<float>(static_cast<int>(std::max(level, 0.0F) + 0.5F)) : level;
  if (taps == 1) return texture.sample(p.u, p.v, lod);
  const float du = (column_longer ? p.du_column : p.du_row) / static_cast<float>(taps);
  const float dv = (column_longer ? p.dv_column : p.dv_row) / static_cast<float>(taps);
  float sum = 0.0F;
  for (int i = 0; i < taps; ++i) {
    const float offset = static_cast<float>(i) - 0.5F * static_cast<float>(taps - 1);
    sum += texture.sample(p.u + offset * du, p.v + offset * dv, lod);
  }
  return sum / static_cast<float>(taps);
}

}  // namespace

World::World(Scene scene, const Random& random) : scene_(std::move(scene)), tracer_(scene_) {
  bake_light(scene_, tracer_, random);
  facets_.push_back(facets_of(scene_.fixed));
  for (const Mesh& mesh : scene_.prototypes) facets_.push_back(facets_of(mesh));
  placements_.push_back({Eigen::Matrix3f::Identity(), Vector3f::Zero(), 1.0F, 0});
  for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
    const Instance& instance = scene_.instances[i];
    placements_.emplace_back();
    placements_.back().mesh = instance.prototype + 1;
    place(i, instance.T_world_object);
    anything_moves_ = anything_moves_ || instance.motion;
  }
  tracer_.commit();
}

void World::place(std::size_t instance, const lie::SE3d& T_world_object) {
  Placement& placement = placements_[instance + 1];
  placement.R_world_object = T_world_object.rotation().matrix().cast<float>();
  placement.position = T_world_object.translation().cast<float>();
  placement.scale = static_cast<float>(scene_.instances[instance].scale);
  tracer_.place(instance, T_world_object, scene_.instances[instance].scale);
}

void World::set_time(double time_s) {
  if (!anything_moves_) return;
  for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
    if (scene_.instances[i].motion) place(i, scene_.instances[i].motion(time_s));
  }
  tracer_.commit();
}

lie::SE3d World::instance_motion(std::uint32_t instance, double t0, double t1) const {
  if (!moves(instance)) return lie::SE3d();
  const auto& motion = scene_.instances[instance - 1].motion;
  return motion(t1) * motion(t0).inverse();
}

Seen World::look_at_sky(const Ray& ray) const {
  // Clouds on a flat layer; near the horizon they fade into haze.
  Seen seen;
  seen.surface = kSkySurface;
  const float up = std::max(ray.direction.z(), 0.02F);
  const float u = 0.25F * ray.direction.x() / up;
  const float v = 0.25F * ray.direction.y() / up;
  const float pixel = ray.d_column.norm() * 0.25F / (up * up);
  const Texture& clouds = scene_.textures[scene_.sky_texture];
  const float lod = fast_log2(std::max(pixel * static_cast<float>(clouds.size()), 0.25F));
  const float haze = std::min(1.0F, 5.0F * up);
  seen.radiance = haze * clouds.sample(u, v, lod) + (1.0F - haze) * 0.95F;
  return seen;
}

float World::lit(const Facet& facet, const Placement& placement, const Vector3f& p) const {
  const float baked = std::max(0.02F, facet.light0 + facet.grad_light.dot(p));
  if (placement.mesh == 0) return baked;
  const Lighting& light = scene_.lighting;
  const float facing = (placement.R_world_object * facet.normal).dot(light.to_sun);
  // Leaves and thin things let some light through, so both sides count.
  return baked * (light.ambient + light.sun * (facing > 0.0F ? facing : -0.35F * facing));
}

Seen World::look(const Ray& ray, const Hit& hit, float footprint) const {
  if (hit.empty()) return look_at_sky(ray);
  const Placement& placement = placements_[hit.instance];
  const Facet& facet = facets_[placement.mesh][hit.triangle];

  // Everything in the object's frame, lengths divided by its scale.
  Vector3f from = ray.origin - placement.position;
  Vector3f d = ray.direction;
  Vector3f d_column = footprint * ray.d_column;
  Vector3f d_row = footprint * ray.d_row;
  if (hit.instance != 0) {
    const Eigen::Matrix3f R = placement.R_world_object.transpose();
    from = R * from / placement.scale;
    d = R * d;
    d_column = R * d_column;
    d_row = R * d_row;
  }
  const float slope = facet.normal.dot(d);
  const float steep = std::abs(slope) < 1e-6F ? (slope < 0.0F ? -1e-6F : 1e-6F) : slope;
  const Vector3f from_facet = from - facet.origin;
  const float t = std::max(0.0F, -facet.normal.dot(from_facet) / steep);
  const Vector3f p = from_facet + t * d;

  // Where the neighbouring pixels' rays meet the same plane.
  const Vector3f p_column = t * (d_column - d * (facet.normal.dot(d_column) / steep));
  const Vector3f p_row = t * (d_row - d * (facet.normal.dot(d_row) / steep));
  const TexturePoint point{facet.u0 + facet.grad_u.dot(p), facet.v0 + facet.grad_v.dot(p),
                           facet.grad_u.dot(p_column),     facet.grad_v.dot(p_column),
                           facet.grad_u.dot(p_row),        facet.grad_v.dot(p_row)};
  Seen seen;
  seen.radiance =
      filtered(scene_.textures[facet.texture], point, footprint < 1.0F) * lit(facet, placement, p);
  seen.distance = t * placement.scale;
  seen.surface = (hit.instance * 0x9E3779B1U) ^ (facet.surface * 0x85EBCA77U);
  seen.instance = hit.instance;
  return seen;
}

}  // namespace imslam::simulation
