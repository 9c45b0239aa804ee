#include "datasets/simulation/light_baker.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kAmbientRays = 12;
constexpr int kSunRays = 4;
constexpr float kLift = 0.01F;       ///< [m] off the surface, against meeting itself
constexpr std::size_t kChunk = 256;  ///< vertices per task; each has its own random stream

std::vector<Vector3f> vertex_normals(const Mesh& mesh) {
  std::vector<Vector3f> normals(mesh.vertices.size(), Vector3f::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Vector3f& a = mesh.vertices[t.a].position;
    const Vector3f normal =
        (mesh.vertices[t.b].position - a).cross(mesh.vertices[t.c].position - a);
    for (const std::uint32_t i : {t.a, t.b, t.c}) normals[i] += normal;
  }
  for (Vector3f& normal : normals) normal.normalize();
  return normals;
}

/// Direction with a density proportional to the cosine to the normal.
Vector3f cosine_direction(const Vector3f& normal, Random& random) {
  Vector3f direction = random.normal3().normalized().cast<float>() + 0.999F * normal;
  return direction.normalized();
}

class Baker {
 public:
  Baker(const Lighting& lighting, const RayTracer& tracer) : light_(lighting), tracer_(tracer) {}

  float ambient(const Vector3f& place, const Vector3f& normal, Random& random) const {
    int open = 0;
    for (int i = 0; i < kAmbientRays; ++i) {
      const Vector3f direction = cosine_direction(normal, random);
      open += tracer_.occluded(place, direction, light_.ambient_reach_m) ? 0 : 1;
    }
    // Things around reflect light too: never quite dark.
    return 0.35F + 0.65F * static_cast<float>(open) / kAmbientRays;
  }

  float direct(const Vector3f& place, const Vector3f& normal, Random& random) const {
    float sum = 0.0F;
    const float facing = normal.dot(light_.to_sun);
    if (light_.sun > 0.0F && facing > 0.0F) {
      int open = 0;
      for (int i = 0; i < kSunRays; ++i) {
        const Vector3f jitter = 0.015F * random.normal3().cast<float>();
        open += tracer_.occluded(place, light_.to_sun + jitter, 1e3F) ? 0 : 1;
      }
      sum += light_.sun * facing * static_cast<float>(open) / kSunRays;
    }
    for (const Lamp& lamp : light_.lamps) {
      const Vector3f to_lamp = lamp.position + 0.08F * random.normal3().cast<float>() - place;
      const float distance = to_lamp.norm();
      const float towards = normal.dot(to_lamp) / distance;
      if (towards <= 0.0F || tracer_.occluded(place, to_lamp, 0.98F)) continue;
      sum += lamp.power * towards / (distance * distance + 0.5F);
    }
    return sum;
  }

 private:
  const Lighting& light_;
  const RayTracer& tracer_;
};

template <typename Function>
void for_each_vertex(Mesh& mesh, const Random& random, const Function& light_at) {
  const std::vector<Vector3f> normals = vertex_normals(mesh);
  const std::size_t count = mesh.vertices.size();
  parallel_for((count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    Random stream = random.fork(chunk);
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      Vertex& vertex = mesh.vertices[i];
      vertex.light = light_at(vertex.position + kLift * normals[i], normals[i], stream);
    }
  });
}

}  // namespace

void bake_light(Scene& scene, const RayTracer& tracer, const Random& random) {
  const Baker baker(scene.lighting, tracer);
  const float ambient = scene.lighting.ambient;
  for_each_vertex(scene.fixed, random.fork(0), [&](const auto& p, const auto& n, Random& stream) {
    const float sky = ambient * baker.ambient(p, n, stream);
    return sky + baker.direct(p, n, stream);
  });
  for (std::size_t k = 0; k < scene.prototypes.size(); ++k) {
    Scene alone;  // a prototype is dimmed by itself only
    alone.fixed = scene.prototypes[k];
    alone.lighting = scene.lighting;
    const RayTracer own(alone);
    const Baker own_baker(alone.lighting, own);
    for_each_vertex(scene.prototypes[k], random.fork(k + 1),
                    [&](const auto& p, const auto& n, Random& stream) {
                      return own_baker.ambient(p, n, stream);
                    });
  }
}

}  // namespace imslam::simulation
