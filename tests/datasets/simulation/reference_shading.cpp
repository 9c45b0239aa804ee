#include "tests/datasets/simulation/reference_shading.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace imslam::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

int wrapped(int i, int size) { return ((i % size) + size) % size; }

/// A triangle carried into the world.
struct Corners {
  const Triangle* triangle;
  const Vertex* vertex[3];
  Vector3d place[3];
  Vector3d normal;
};

Corners corners_of(const Scene& scene, const Hit& hit) {
  const Instance* instance = hit.instance == 0 ? nullptr : &scene.instances[hit.instance - 1];
  const Mesh& mesh = instance == nullptr ? scene.fixed : scene.prototypes[instance->prototype];
  Corners c;
  c.triangle = &mesh.triangles[hit.triangle];
  const std::uint32_t index[3] = {c.triangle->a, c.triangle->b, c.triangle->c};
  for (int i = 0; i < 3; ++i) {
    c.vertex[i] = &mesh.vertices[index[i]];
    const Vector3d p = c.vertex[i]->position.cast<double>();
    c.place[i] = instance == nullptr ? p : instance->T_world_object * (instance->scale * p);
  }
  c.normal = (c.place[1] - c.place[0]).cross(c.place[2] - c.place[0]).normalized();
  return c;
}

/// Where the line along `direction` meets the triangle's plane.
struct Meeting {
  double t = 0.0;
  Vector2d uv = Vector2d::Zero();  ///< [tiles]
  double light = 0.0;
};

Meeting meet(const Corners& c, const Vector3d& origin, const Vector3d& direction) {
  // origin + t direction = place0 + s1 (place1 - place0) + s2 (place2 - place0)
  Eigen::Matrix3d A;
  A << -direction, c.place[1] - c.place[0], c.place[2] - c.place[0];
  const Vector3d solution = A.fullPivLu().solve(origin - c.place[0]);
  const double share[3] = {1.0 - solution[1] - solution[2], solution[1], solution[2]};
  Meeting meeting;
  meeting.t = solution[0];
  for (int i = 0; i < 3; ++i) {
    meeting.uv += share[i] * c.vertex[i]->uv.cast<double>();
    meeting.light += share[i] * static_cast<double>(c.vertex[i]->light);
  }
  return meeting;
}

double rounded_when_partial(double lod, double footprint) {
  return footprint < 1.0 ? std::floor(std::max(lod, 0.0) + 0.5) : lod;
}

}  // namespace

ReferenceTexture::ReferenceTexture(const Texture& texture) {
  Level level(static_cast<std::size_t>(texture.size()));
  for (std::size_t row = 0; row < level.size(); ++row) {
    const std::uint8_t* first = texture.pixels() + row * level.size();
    level[row].assign(first, first + level.size());
  }
  levels_.push_back(level);
  while (levels_.back().size() > 1) {
    const Level& fine = levels_.back();
    Level coarse(fine.size() / 2, std::vector<int>(fine.size() / 2));
    for (std::size_t y = 0; y < coarse.size(); ++y) {
      for (std::size_t x = 0; x < coarse.size(); ++x) {
        const int sum = fine[2 * y][2 * x] + fine[2 * y][2 * x + 1] + fine[2 * y + 1][2 * x] +
                        fine[2 * y + 1][2 * x + 1];
        coarse[y][x] = static_cast<int>(std::lround(std::floor(sum / 4.0 + 0.5)));
      }
    }
    levels_.push_back(coarse);
  }
}

double ReferenceTexture::bilinear(const Level& level, double u, double v) const {
  const int size = static_cast<int>(level.size());
  const double x = u * size - 0.5;  // texel centres lie at half integers
  const double y = v * size - 0.5;
  const int column = static_cast<int>(std::floor(x));
  const int row = static_cast<int>(std::floor(y));
  const auto texel = [&](int at_row, int at_column) {
    return level[static_cast<std::size_t>(wrapped(at_row, size))]
                [static_cast<std::size_t>(wrapped(at_column, size))] /
           255.0;
  };
  const double fx = x - column;
  const double fy = y - row;
  return (1 - fy) * ((1 - fx) * texel(row, column) + fx * texel(row, column + 1)) +
         fy * ((1 - fx) * texel(row + 1, column) + fx * texel(row + 1, column + 1));
}

double ReferenceTexture::sample(double u, double v, double lod) const {
  const double level = std::clamp(lod, 0.0, static_cast<double>(levels_.size() - 1));
  const auto fine = static_cast<std::size_t>(level);
  const std::size_t coarse = std::min(fine + 1, levels_.size() - 1);
  const double share = level - static_cast<double>(fine);
  return (1 - share) * bilinear(levels_[fine], u, v) + share * bilinear(levels_[coarse], u, v);
}

double reference_distance(const Scene& scene, const Hit& hit, const ReferenceRay& ray) {
  return meet(corners_of(scene, hit), ray.origin, ray.direction).t;
}

ReferenceShading::ReferenceShading(const Scene& scene)
    : scene_(scene), textures_(scene.textures.begin(), scene.textures.end()) {}

ReferenceLook ReferenceShading::look(const ReferenceRay& ray,
                                     const Hit& hit,
                                     double footprint) const {
  if (hit.empty()) return look_at_sky(ray, footprint);
  const Corners corners = corners_of(scene_, hit);
  const ReferenceTexture& texture = textures_[corners.triangle->texture];
  const Meeting here = meet(corners, ray.origin, ray.direction);
  // Sides of the footprint [tiles], by central differences.
  const auto side = [&](const Vector3d& step) -> Vector2d {
    constexpr double kShare = 1e-4;
    const Vector2d after = meet(corners, ray.origin, ray.direction + kShare * step).uv;
    const Vector2d before = meet(corners, ray.origin, ray.direction - kShare * step).uv;
    return footprint * (after - before) / (2.0 * kShare);
  };
  const Vector2d column = side(ray.d_column);
  const Vector2d row = side(ray.d_row);
  const Vector2d longer = column.norm() > row.norm() ? column : row;
  const double texels = texture.size();
  const double length = texels * longer.norm();
  const double area = texels * texels * std::abs(column.x() * row.y() - column.y() * row.x());
  const double width = std::max(1.0, area / length);
  const int taps = static_cast<int>(std::clamp(std::floor(length / width + 0.5), 1.0, 5.0));
  const double lod = rounded_when_partial(std::log2(std::max(length / taps, 0.25)), footprint);
  double sum = 0.0;
  for (int i = 0; i < taps; ++i) {
    const Vector2d uv = here.uv + (i - 0.5 * (taps - 1)) / taps * longer;
    sum += texture.sample(uv.x(), uv.y(), lod) / taps;
  }
  double light = std::max(here.light, 0.02);
  if (hit.instance != 0) {
    const double facing = corners.normal.dot(scene_.lighting.to_sun.cast<double>());
    const double through = facing > 0.0 ? facing : -0.35 * facing;
    light *= static_cast<double>(scene_.lighting.ambient) +
             static_cast<double>(scene_.lighting.sun) * through;
  }
  return {sum * light, here.t};
}

ReferenceLook ReferenceShading::look_at_sky(const ReferenceRay& ray, double footprint) const {
  const ReferenceTexture& texture = textures_[scene_.sky_texture];
  const double up = std::max(ray.direction.z(), 0.02);
  const double u = 0.25 * ray.direction.x() / up;
  const double v = 0.25 * ray.direction.y() / up;
  // Seen ever flatter towards the horizon: the layer slides away with the square of 1 / up.
  const double texels = ray.d_column.norm() * 0.25 / (up * up) * texture.size();
  const double lod = rounded_when_partial(std::log2(std::max(texels, 0.25)), footprint);
  const double haze = std::min(1.0, 5.0 * up);
  return {haze * texture.sample(u, v, lod) + (1.0 - haze) * 0.95,
          std::numeric_limits<double>::infinity()};
}

}  // namespace imslam::simulation
