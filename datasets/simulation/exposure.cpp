#include "datasets/simulation/exposure.hpp"

#include <algorithm>
#include <cmath>

namespace imslam::simulation {
namespace {

constexpr double kProbe_s = 0.5;
constexpr int kStride = 24;       ///< [px] between the probe's rays
constexpr double kFollow = 0.45;  ///< share of the error that is corrected per probe
constexpr double kStep = 0.5;     ///< sigma of a sudden change of the logarithm

double mean_radiance(const World& world, const RayTable& rays, const lie::SE3d& T_world_camera) {
  const Eigen::Matrix3f R = T_world_camera.rotation().matrix().cast<float>();
  const Eigen::Vector3f origin = T_world_camera.translation().cast<float>();
  double sum = 0.0;
  int count = 0;
  RayPacket packet;
  const auto look = [&] {
    Hit hits[kLanes];
    SeenPacket seen;
    world.closest(origin, packet, false, hits);
    world.look(origin, packet, hits, kStride, seen);
    for (std::size_t i = 0; i < packet.count; ++i) {
      sum += std::min(2.0F, seen.radiance[i]);
      ++count;
    }
    packet.count = 0;
  };
  for (int row = kStride / 2; row < rays.height(); row += kStride) {
    for (int column = kStride / 2; column < rays.width(); column += kStride) {
      rays.add_pixel(R, row, column, packet);
      if (packet.count == kLanes) look();
    }
  }
  if (packet.count > 0) look();
  return count > 0 ? std::max(sum / count, 1e-3) : 0.5;
}

}  // namespace

Exposure::Exposure(const SimulationOptions& options,
                   World& world,
                   const RayTable& rays,
                   const MotionSpline& motion,
                   const lie::SE3d& T_body_left,
                   Random random) {
  const ImageOptions& image = options.image;
  right_factor_ = std::exp(0.01 * image.right_gain_percent * random.normal());
  const double steps_per_probe = image.exposure_steps * kProbe_s / 60.0;
  for (double t = 0.0;; t += kProbe_s) {
    const bool measure = image.auto_exposure || log_gains_.empty();
    double next = log_gains_.empty() ? 0.0 : log_gains_.back();
    if (measure) {
      world.set_time(t);
      const lie::SE3d T_world_left = motion.at(t).T_world_body * T_body_left;
      const double wanted = std::log(image.brightness / mean_radiance(world, rays, T_world_left));
      next += (log_gains_.empty() ? 1.0 : kFollow) * (wanted - next);
    }
    if (random.chance(steps_per_probe)) next += kStep * random.normal();
    log_gains_.push_back(next);
    if (t >= motion.duration_s()) break;
  }
  log_gains_.push_back(log_gains_.back());
}

double Exposure::gain(double time_s) const {
  const double position = std::max(0.0, time_s / kProbe_s);
  const auto i = std::min(static_cast<std::size_t>(position), log_gains_.size() - 2);
  const double share = std::min(1.0, position - static_cast<double>(i));
  return std::exp(log_gains_[i] + share * (log_gains_[i + 1] - log_gains_[i]));
}

}  // namespace imslam::simulation
