#include "datasets/simulation/ray_tracer.hpp"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>

#include <cstring>
#include <string>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::simulation {
namespace {

using Matrix34f = Eigen::Matrix<float, 3, 4>;  // column major, as Embree takes it

constexpr float kNearest = 0.02F;  ///< [m] nothing is nearer to a lens

/// One building thread: the tree, and so the winner of a tie, is always the same.
void commit_scene(RTCScene scene) {
  const SingleThreadScope scope;
  rtcCommitScene(scene);
}

/// The mesh's triangles, its vertices carried by `M`.
RTCGeometry make_geometry(RTCDevice device, const Mesh& mesh, const Matrix34f& M) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* positions = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), mesh.vertices.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f position = M * mesh.vertices[i].position.homogeneous();
    std::memcpy(positions + 3 * i, position.data(), 3 * sizeof(float));
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
  return geometry;
}

/// Attaches the geometry under `id` and gives up the caller's reference.
void attach(RTCScene scene, RTCGeometry geometry, std::size_t id) {
  rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(id));
  rtcReleaseGeometry(geometry);
}

RTCScene new_scene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  // Robust: no ray slips through the shared edge of two triangles.
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  return scene;
}

Matrix34f transform(const lie::SE3d& T_world_object, double scale) {
  Matrix34f M;
  M << (scale * T_world_object.rotation().matrix()).cast<float>(),
      T_world_object.translation().cast<float>();
  return M;
}

}  // namespace

/// Two trees: what rests is one tree of triangles in the world's frame, since trees of trees are
/// slow where they overlap, as crowns in a wood do; what moves is placed in a tree of instances.
class RayTracer::Implementation {
 public:
  explicit Implementation(const Scene& scene)
      // Naming a number of threads here would hold all of oneTBB to it as long as the device lives.
      : device_(rtcNewDevice("set_affinity=0")), movers_(scene.instances.size(), nullptr) {
    expects(device_ != nullptr, "RayTracer: Embree gave no device");
    resting_ = new_scene(device_);
    attach(resting_, make_geometry(device_, scene.fixed, transform(lie::SE3d(), 1.0)), 0);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
      const Instance& instance = scene.instances[i];
      const Matrix34f M = transform(instance.T_world_object, instance.scale);
      const Mesh& mesh = scene.prototypes[instance.prototype];
      if (!instance.motion)
        attach(resting_, make_geometry(device_, mesh, M), i + 1);
      else
        add_mover(i, mesh, M);
    }
    commit_scene(resting_);
    if (moving_ != nullptr) commit_scene(moving_);
  }

  ~Implementation() {
    if (moving_ != nullptr) rtcReleaseScene(moving_);
    rtcReleaseScene(resting_);
    rtcReleaseDevice(device_);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void place(std::size_t i, const lie::SE3d& T_world_object, double scale) {
    expects(movers_[i] != nullptr, "RayTracer::place: the instance is at rest");
    const Matrix34f M = transform(T_world_object, scale);
    rtcSetGeometryTransform(movers_[i], 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, M.data());
    rtcCommitGeometry(movers_[i]);
  }

  RTCScene top() const { return moving_ != nullptr ? moving_ : resting_; }

 private:
  void add_mover(std::size_t i, const Mesh& mesh, const Matrix34f& M) {
    if (moving_ == nullptr) {
      moving_ = rtcNewScene(device_);
      rtcSetSceneFlags(moving_, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
      add_instance(resting_, 0, transform(lie::SE3d(), 1.0));
    }
    RTCScene scene = new_scene(device_);
    attach(scene, make_geometry(device_, mesh, transform(lie::SE3d(), 1.0)), 0);
    commit_scene(scene);
    movers_[i] = add_instance(scene, i + 1, M);
    rtcReleaseScene(scene);
  }

  RTCGeometry add_instance(RTCScene scene, std::size_t id, const Matrix34f& M) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, scene);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, M.data());
    rtcCommitGeometry(geometry);
    attach(moving_, geometry, id);
    return geometry;
  }

  RTCDevice device_;
  std::vector<RTCGeometry> movers_;  ///< of each instance of the scene; null: it rests
  RTCScene resting_ = nullptr;
  RTCScene moving_ = nullptr;  ///< null: nothing moves
};

RayTracer::RayTracer(const Scene& scene)
    : implementation_(std::make_unique<Implementation>(scene)) {}
RayTracer::~RayTracer() = default;

void RayTracer::place(std::size_t instance, const lie::SE3d& T_world_object, double scale) {
  implementation_->place(instance, T_world_object, scale);
}

void RayTracer::commit() { commit_scene(implementation_->top()); }

void RayTracer::closest(const Eigen::Vector3f& origin,
                        const RayPacket& rays,
                        bool coherent,
                        Hit* hits) const {
  RTCRayHit16 packet;
  alignas(64) int valid[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i) {
    valid[i] = i < rays.count ? -1 : 0;
    packet.ray.org_x[i] = origin.x();
    packet.ray.org_y[i] = origin.y();
    packet.ray.org_z[i] = origin.z();
    packet.ray.dir_x[i] = rays.direction.x[i];
    packet.ray.dir_y[i] = rays.direction.y[i];
    packet.ray.dir_z[i] = rays.direction.z[i];
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
    // Under instance 0 or none lie the things at rest, under the others one geometry each.
    const std::uint32_t above = packet.hit.instID[0][i];
    const bool rests = above == RTC_INVALID_GEOMETRY_ID || above == 0;
    const bool found = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    hits[i] = found ? Hit{rests ? packet.hit.geomID[i] : above, packet.hit.primID[i]} : Hit{};
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
