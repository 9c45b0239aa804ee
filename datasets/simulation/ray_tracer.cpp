#include "datasets/simulation/ray_tracer.hpp"

#include <embree3/rtcore.h>

#include <cstring>
#include <string>

#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

constexpr float kNearest = 0.02F;  ///< [m] nothing is nearer to a lens

RTCScene build_scene(RTCDevice device, const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* positions = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), mesh.vertices.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    std::memcpy(positions + 3 * i, mesh.vertices[i].position.data(), 3 * sizeof(float));
  }
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& triangle = mesh.triangles[i];
    indices[3 * i] = triangle.a;
    indices[3 * i + 1] = triangle.b;
    indices[3 * i + 2] = triangle.c;
  }
  rtcCommitGeometry(geometry);
  RTCScene scene = rtcNewScene(device);
  // Robust: no ray slips through the shared edge of two triangles.
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

}  // namespace

class RayTracer::Implementation {
 public:
  explicit Implementation(const Scene& scene)
      // One building thread: the tree, and so the winner of a tie, is always the same.
      : device_(rtcNewDevice("threads=1,set_affinity=0")) {
    expects(device_ != nullptr, "RayTracer: Embree gave no device");
    top_ = rtcNewScene(device_);
    rtcSetSceneFlags(top_, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
    add_instance(build_scene(device_, scene.fixed));
    for (const Mesh& mesh : scene.prototypes) prototypes_.push_back(build_scene(device_, mesh));
    for (const Instance& instance : scene.instances) {
      RTCScene prototype = prototypes_[instance.prototype];
      rtcRetainScene(prototype);
      add_instance(prototype);
      place(instances_.size() - 1, instance.T_world_object, instance.scale);
    }
    place(0, lie::SE3d(), 1.0);
    rtcCommitScene(top_);
  }

  ~Implementation() {
    for (RTCGeometry instance : instances_) rtcReleaseGeometry(instance);
    for (RTCScene prototype : prototypes_) rtcReleaseScene(prototype);
    rtcReleaseScene(top_);
    rtcReleaseDevice(device_);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void place(std::size_t index, const lie::SE3d& T_world_object, double scale) {
    Eigen::Matrix<float, 3, 4> M;  // column major
    M << (scale * T_world_object.rotation().matrix()).cast<float>(),
        T_world_object.translation().cast<float>();
    RTCGeometry instance = instances_[index];
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, M.data());
    rtcCommitGeometry(instance);
  }

  RTCScene top() const { return top_; }

 private:
  /// Takes over the caller's reference to `scene`.
  void add_instance(RTCScene scene) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, scene);
    rtcReleaseScene(scene);
    rtcAttachGeometry(top_, geometry);
    instances_.push_back(geometry);
  }

  RTCDevice device_;
  RTCScene top_ = nullptr;
  std::vector<RTCScene> prototypes_;
  std::vector<RTCGeometry> instances_;
};

RayTracer::RayTracer(const Scene& scene)
    : implementation_(std::make_unique<Implementation>(scene)) {}
RayTracer::~RayTracer() = default;

void RayTracer::place(std::size_t instance, const lie::SE3d& T_world_object, double scale) {
  implementation_->place(instance + 1, T_world_object, scale);
}

void RayTracer::commit() { rtcCommitScene(implementation_->top()); }

void RayTracer::closest(const Eigen::Vector3f& origin,
                        const RayPacket& rays,
                        bool coherent,
                        Hit* hits) const {
  RTCRayHit16 packet;
  alignas(64) int valid[RayPacket::kLanes];
  for (std::size_t i = 0; i < RayPacket::kLanes; ++i) {
    valid[i] = i < rays.count ? -1 : 0;
    packet.ray.org_x[i] = origin.x();
    packet.ray.org_y[i] = origin.y();
    packet.ray.org_z[i] = origin.z();
    packet.ray.dir_x[i] = rays.x[i];
    packet.ray.dir_y[i] = rays.y[i];
    packet.ray.dir_z[i] = rays.z[i];
    packet.ray.tnear[i] = kNearest;
    packet.ray.tfar[i] = std::numeric_limits<float>::infinity();
    packet.ray.time[i] = 0.0F;
    packet.ray.mask[i] = 0xFFFFFFFFU;
    packet.ray.id[i] = 0;
    packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, implementation_->top(), &context, &packet);
  for (std::size_t i = 0; i < rays.count; ++i) {
    const bool found = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    hits[i] = found ? Hit{packet.hit.instID[0][i], packet.hit.primID[i]} : Hit{};
  }
}

bool RayTracer::occluded(const Eigen::Vector3f& origin,
                         const Eigen::Vector3f& direction,
                         float reach) const {
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tfar = reach;
  ray.mask = 0xFFFFFFFFU;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(implementation_->top(), &context, &ray);
  return ray.tfar < 0.0F;
}

}  // namespace imslam::simulation
