#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "datasets/simulation/packet.hpp"
#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {

/// What a ray meets first. Instance 0 is the fixed mesh, instance i + 1 is scene.instances[i].
struct Hit {
  static constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t instance = kNothing;
  std::uint32_t triangle = kNothing;

  bool empty() const { return instance == kNothing; }
};

/// Finds which triangle a ray meets (Embree). It gives identities only: distances are computed
/// from the triangle's plane by the caller, so they do not depend on the processor's instructions.
class RayTracer {
 public:
  explicit RayTracer(const Scene& scene);
  ~RayTracer();
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  /// Places instance i (of scene.instances); takes effect with commit().
  void place(std::size_t instance, const lie::SE3d& T_world_object, double scale);
  void commit();

  /// Fills the first rays.count hits. `coherent`: neighbouring pixels. Thread-safe between commits.
  void closest(const Eigen::Vector3f& origin,
               const RayPacket& rays,
               bool coherent,
               Hit* hits) const;

  bool occluded(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float reach) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace imslam::simulation
