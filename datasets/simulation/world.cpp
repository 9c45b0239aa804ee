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

}  // namespace

World::World(Scene scene, const Random& random)
    : scene_(std::move(scene)), pool_(scene_.textures), tracer_(scene_) {
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
}

void World::place(std::size_t instance, const lie::SE3d& T_world_object) {
  Placement& placement = placements_[instance + 1];
  placement.R_world_object = T_world_object.rotation().matrix().cast<float>();
  placement.position = T_world_object.translation().cast<float>();
  placement.scale = static_cast<float>(scene_.instances[instance].scale);
}

void World::set_time(double time_s) {
  if (!anything_moves_) return;
  for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
    const Instance& instance = scene_.instances[i];
    if (!instance.motion) continue;
    const lie::SE3d T_world_object = instance.motion(time_s);
    place(i, T_world_object);
    tracer_.place(i, T_world_object, instance.scale);
  }
  tracer_.commit();
}

lie::SE3d World::instance_motion(std::uint32_t instance, double t0, double t1) const {
  if (!moves(instance)) return lie::SE3d();
  const auto& motion = scene_.instances[instance - 1].motion;
  return motion(t1) * motion(t0).inverse();
}

}  // namespace imslam::simulation
