#include "datasets/simulation/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "datasets/simulation/exposure.hpp"
#include "datasets/simulation/image_sensor.hpp"
#include "datasets/simulation/motion.hpp"
#include "datasets/simulation/scene.hpp"
#include "datasets/simulation/truth.hpp"
#include "datasets/simulation/view.hpp"
#include "datasets/simulation/world.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::simulation {
namespace {

constexpr std::int64_t kEpoch_ns = 1'700'000'000'000'000'000;  ///< stamp of the first sample

/// Independent streams of the sequence's seed.
enum Stream : std::uint64_t { kScene = 1, kRig, kLight, kImuErrors, kImuNoise, kExposure, kImage };

/// Engine or rotors start half-way through the rest and run to the end; what stands still is off.
std::vector<VibrationLevel> vibration_levels(const SimulationOptions& options) {
  if (options.motion == "static") return {};
  return {{0.5 * options.rest_s, 0.0, 0.0}, {0.5 * options.rest_s + 0.5, 1.0, 1.0}};
}

SimulationOptions validated(const SimulationOptions& options) {
  options.validate();
  return options;
}

}  // namespace

class Simulator::Implementation {
 public:
  explicit Implementation(const SimulationOptions& options)
      : options_(validated(options)),
        random_(static_cast<std::uint64_t>(options.seed)),
        bank_(options.textures),
        world_(make_scene(options_, bank_, random_.fork(kScene)), random_.fork(kLight)),
        rig_(make_rig(options_.camera, random_.fork(kRig))),
        motion_(make_motion(options_, world_.scene().path)),
        errors_(draw_imu_errors(options_.imu, random_.fork(kImuErrors))),
        left_rays_(rig_.left),
        right_rays_(rig_.right),
        left_sensor_(options_.image, rig_.left),
        right_sensor_(options_.image, rig_.right),
        exposure_(
            options_, world_, left_rays_, motion_, rig_.T_body_left, random_.fork(kExposure)) {}

  SimulatedFrame render(double time_s, const FrameRequest& request) {
    expects(time_s >= 0.0 && time_s <= motion_.duration_s(),
            "Simulator::render: time out of range");
    world_.set_time(time_s);
    SimulatedFrame frame;
    frame.time_s = time_s;
    frame.time_ns = stamp_ns(time_s - options_.imu.camera_delay_s);
    frame.width = rig_.left.width();
    frame.height = rig_.left.height();
    frame.truth = motion_.at(time_s);
    const double gain = exposure_.gain(time_s);
    const auto noise = random_.fork(kImage).fork(static_cast<std::uint64_t>(frame.time_ns)).bits();
    const CameraMotion left = camera_motion(frame.truth, rig_.T_body_left);
    const CameraMotion right = camera_motion(frame.truth, rig_.T_body_right);
    frame.right =
        shoot(right, right_rays_, right_sensor_, time_s, gain * exposure_.right_factor(), ~noise);
    frame.left = shoot(left, left_rays_, left_sensor_, time_s, gain, noise);
    if (request.depth) frame.depth = depth_of(view_, left_rays_);
    if (request.flow_to_s) add_flow(*request.flow_to_s, left.T_world_camera, frame);
    return frame;
  }

  std::int64_t stamp_ns(double time_s) const { return kEpoch_ns + to_nanoseconds(time_s); }

  const SimulationOptions options_;
  const Random random_;
  TextureBank bank_;
  World world_;
  const StereoRig rig_;
  const MotionSpline motion_;
  const ImuErrors errors_;

 private:
  GrayImage shoot(const CameraMotion& motion,
                  const RayTable& rays,
                  const ImageSensor& sensor,
                  double time_s,
                  double gain,
                  std::uint64_t noise) {
    render_view(world_, rays, motion.T_world_camera, options_.antialias, view_);
    const double exposure_s = 1e-3 * options_.image.exposure_ms;
    if (exposure_s <= 0.0) return sensor.expose(view_.radiance, gain, noise);
    return sensor.expose(blur_motion(view_, world_, rays, motion, time_s, exposure_s), gain, noise);
  }

  void add_flow(double flow_to_s, const lie::SE3d& T_world_left0, SimulatedFrame& frame) const {
    const lie::SE3d T_world_left1 = motion_.at(flow_to_s).T_world_body * rig_.T_body_left;
    Flow flow = flow_of(view_, world_, left_rays_, rig_.left, T_world_left0, T_world_left1,
                        frame.time_s, flow_to_s);
    frame.flow = std::move(flow.displacement);
    frame.flow_valid = std::move(flow.valid);
  }

  RayTable left_rays_;
  RayTable right_rays_;
  ImageSensor left_sensor_;
  ImageSensor right_sensor_;
  Exposure exposure_;
  View view_;  ///< reused between images
};

Simulator::Simulator(const SimulationOptions& options)
    : implementation_(std::make_unique<Implementation>(options)) {}
Simulator::~Simulator() = default;

const SimulationOptions& Simulator::options() const { return implementation_->options_; }
const StereoRig& Simulator::rig() const { return implementation_->rig_; }
const MotionSpline& Simulator::motion() const { return implementation_->motion_; }
const ImuErrors& Simulator::imu_errors() const { return implementation_->errors_; }
std::string Simulator::texture_bank() const { return implementation_->bank_.description(); }

std::size_t Simulator::frame_count() const {
  return static_cast<std::size_t>(options().duration_s * options().frame_rate_hz + 1e-9) + 1;
}

double Simulator::frame_time_s(std::size_t index) const {
  return static_cast<double>(index) / options().frame_rate_hz;
}

SimulatedFrame Simulator::render(double time_s, const FrameRequest& request) {
  return implementation_->render(time_s, request);
}

ImuModel Simulator::imu() const {
  return ImuModel(imu_errors(), motion(), stamp_ns(0.0), implementation_->random_.fork(kImuNoise),
                  vibration_levels(options()));
}

std::size_t Simulator::imu_count() const {
  return static_cast<std::size_t>(options().duration_s * options().imu.rate_hz + 1e-9) + 1;
}

std::int64_t Simulator::stamp_ns(double time_s) const { return implementation_->stamp_ns(time_s); }

}  // namespace imslam::simulation
