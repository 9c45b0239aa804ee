#include "slam/training/flow_fields.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/training/bounds.hpp"
#include "slam/training/flow_scene.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBorder = 4.0;    // [px] without matches
constexpr double kSkyDepth = 1e5;  // as good as infinitely far
constexpr double kNearestDepth = 0.02;
constexpr int kProbes = 60;  // rays that tell how far the scene is

double log_uniform(double low, double high, Random& random) {
  return low * std::pow(high / low, random.uniform());
}

enum class Carrier { kFree, kVehicle };

StereoCamera draw_camera(Random& random) {
  StereoCamera camera;
  camera.width = static_cast<int>(random.integer(480, 1300));
  camera.height = static_cast<int>(camera.width * random.uniform(0.28, 0.8));
  const double half_angle = 0.5 * random.uniform(50.0, 105.0) * M_PI / 180.0;
  camera.fx = 0.5 * camera.width / std::tan(half_angle);
  camera.fy = camera.fx * random.uniform(0.98, 1.02);
  camera.cx = camera.width * random.uniform(0.44, 0.56);
  camera.cy = camera.height * random.uniform(0.42, 0.58);
  return camera;
}

FlowScene::Kind draw_kind(Carrier carrier, Random& random) {
  if (carrier == Carrier::kVehicle && random.chance(0.8)) return FlowScene::Kind::kStreet;
  constexpr std::array<FlowScene::Kind, 6> kKinds{
      FlowScene::Kind::kRoom,   FlowScene::Kind::kRoom,    FlowScene::Kind::kStreet,
      FlowScene::Kind::kGround, FlowScene::Kind::kClutter, FlowScene::Kind::kRelief};
  return kKinds[static_cast<std::size_t>(random.integer(0, 5))];
}

/// R_world_left: how the camera is held.
lie::SO3d draw_attitude(Carrier carrier, FlowScene::Kind kind, Random& random) {
  const double shake = carrier == Carrier::kVehicle ? 0.03 : 0.2;
  double pitch = shake * random.normal();
  if (kind == FlowScene::Kind::kGround) pitch -= random.uniform(0.2, 1.6);  // looks down
  double yaw = 0.2 * random.normal();
  if (kind == FlowScene::Kind::kRoom) yaw = random.uniform(-M_PI, M_PI);
  return lie::SO3d::exp({0.0, yaw, 0.0}) * lie::SO3d::exp({pitch, 0.0, 0.0}) *
         lie::SO3d::exp({0.0, 0.0, shake * random.normal()});
}

lie::SE3d draw_motion(Carrier carrier, double median_depth, bool still, Random& random) {
  Vector3d direction = random.normal3();
  Vector3d turn;
  double length = 0.0;
  if (carrier == Carrier::kVehicle) {
    direction = {0.04 * random.normal(), 0.03 * random.normal(), 1.0};
    if (random.chance(0.05)) direction = -direction;
    length = median_depth * log_uniform(0.008, 0.15, random);
    turn = {0.003 * random.normal(), 0.02 * random.normal(), 0.003 * random.normal()};
  } else {
    if (random.chance(0.3)) direction.y() *= 0.2;  // people and drones mostly move level
    length = median_depth * log_uniform(0.0015, 0.1, random);
    turn = random.normal3() * log_uniform(0.0005, 0.05, random);
  }
  if (still) length = 0.0;
  return {lie::SO3d::exp(turn), length * direction.normalized()};
}

/// Where matches may be: patches of an image have no texture, others are covered.
class Holes {
 public:
  Holes(const StereoCamera& camera, Random& random) {
    for (int i = 0; i < 3; ++i) {
      waves_.push_back({random.uniform(-12.0, 12.0) / camera.width,
                        random.uniform(-12.0, 12.0) / camera.width, random.uniform(0.0, 6.28)});
    }
    threshold_ = random.chance(0.5) ? -9.0 : random.uniform(-1.5, 1.0);
    if (!random.chance(0.3)) return;
    const Vector2d size(camera.width, camera.height);
    const Vector2d corner{random.uniform(-0.2, 0.8), random.uniform(-0.2, 0.8)};
    low_ = corner.cwiseProduct(size);
    high_ = low_ + random.uniform(0.2, 0.6) * size;
  }

  bool at(const Vector2d& pixel) const {
    if ((pixel.array() > low_.array()).all() && (pixel.array() < high_.array()).all()) return true;
    double texture = 0.0;
    for (const Vector3d& w : waves_)
      texture += std::sin(w.x() * pixel.x() + w.y() * pixel.y() + w.z());
    return texture < threshold_;
  }

 private:
  std::vector<Vector3d> waves_;
  double threshold_ = 0.0;
  Vector2d low_ = Vector2d::Zero();
  Vector2d high_ = Vector2d::Zero();
};

/// `count` places: on a jittered grid, as matchers with one point per cell have them, or anywhere.
std::vector<Vector2d> draw_places(const StereoCamera& camera, int count, Random& random) {
  const double width = camera.width - 2.0 * kBorder;
  const double height = camera.height - 2.0 * kBorder;
  std::vector<Vector2d> places;
  if (random.chance(0.3)) {
    for (int i = 0; i < count; ++i) {
      places.push_back({kBorder + width * random.uniform(), kBorder + height * random.uniform()});
    }
    return places;
  }
  const double cell = std::sqrt(width * height / count);
  for (double v = 0.0; v < height; v += cell) {
    for (double u = 0.0; u < width; u += cell) {
      const Vector2d place{u + cell * random.uniform(), v + cell * random.uniform()};
      if (place.x() < width && place.y() < height) {
        places.push_back(place + Vector2d::Constant(kBorder));
      }
    }
  }
  return places;
}

/// One field in the making.
class FieldMaker {
 public:
  FieldMaker(const FlowFieldOptions& options, Random& random)
      : options_(options),
        random_(random),
        carrier_(random.chance(0.35) ? Carrier::kVehicle : Carrier::kFree),
        kind_(draw_kind(carrier_, random)),
        scene_(kind_, random),
        R_world_left_(draw_attitude(carrier_, kind_, random)) {
    field_.camera = draw_camera(random);
    const double depth = median_depth();
    field_.camera.baseline_m = depth * log_uniform(0.01, 0.08, random);
    field_.T_left0_left1 =
        draw_motion(carrier_, depth, random.chance(options.standing_still), random);
    draw_movers(depth);
    sky_ = random.chance(0.4);
  }

  FlowField make() {
    const Holes holes(field_.camera, random_);
    const auto count =
        static_cast<int>(log_uniform(options_.least_points, options_.most_points, random_));
    const double outliers =
        random_.chance(options_.with_outliers) ? random_.uniform(0.0, options_.most_outliers) : 0.0;
    flow_noise_ = log_uniform(options_.least_noise, options_.most_noise, random_);
    disparity_noise_ = flow_noise_ * random_.uniform(0.7, 2.0);
    weights_vary_ = random_.chance(0.3);
    for (const Vector2d& place : draw_places(field_.camera, count, random_)) {
      if (!holes.at(place)) add_match(place, random_.chance(outliers));
    }
    return std::move(field_);
  }

 private:
  Vector3d ray_at(const Vector2d& pixel) const {
    const StereoCamera& c = field_.camera;
    return {(pixel.x() - c.cx) / c.fx, (pixel.y() - c.cy) / c.fy, 1.0};
  }

  double median_depth() {
    std::vector<double> depths;
    for (int i = 0; i < kProbes; ++i) {
      const Vector2d pixel{field_.camera.width * random_.uniform(),
                           field_.camera.height * random_.uniform()};
      const auto hit = scene_.cast(R_world_left_ * ray_at(pixel));
      if (hit) depths.push_back(hit->distance);  // rays have z = 1: along them depth is distance
    }
    if (depths.empty()) return 10.0;
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return *middle;
  }

  void draw_movers(double depth) {
    moved_.assign(static_cast<std::size_t>(scene_.object_count()), Vector3d::Zero());
    if (moved_.empty() || !random_.chance(options_.with_movers)) return;
    for (int i = 0; i < 2; ++i) {
      const auto which = random_.integer(0, static_cast<std::int64_t>(moved_.size()) - 1);
      moved_[static_cast<std::size_t>(which)] =
          random_.normal3() * depth * log_uniform(0.003, 0.08, random_);
    }
  }

  void add_match(const Vector2d& place, bool outlier) {
    const Vector3d ray = ray_at(place);
    const auto hit = scene_.cast(R_world_left_ * ray);
    if (!hit && !sky_) return;
    const double depth = hit ? hit->distance : kSkyDepth;
    Vector3d p_left0 = depth * ray;
    if (depth < kNearestDepth) return;
    if (hit && hit->object >= 0) {
      p_left0 += moved_[static_cast<std::size_t>(hit->object)];  // an object's step, any axes
    }
    const Vector3d p_left1 = field_.T_left0_left1.inverse() * p_left0;
    if (p_left1.z() < kNearestDepth) return;
    const StereoCamera& camera = field_.camera;
    const Vector3d seen = camera.project(p_left1);
    vo::Correspondence match;
    match.left0 = place;
    const double noise = flow_noise_ * std::exp(0.4 * random_.normal());
    match.left1 = seen.head<2>() + noise * Vector2d{random_.normal(), random_.normal()};
    if (outlier) {
      const double reach = random_.chance(0.5) ? 40.0 : 4.0;
      match.left1 += reach * Vector2d{random_.normal(), random_.normal()};
    }
    if (!(match.left1.x() > 0.0 && match.left1.x() < camera.width - 1.0 && match.left1.y() > 0.0 &&
          match.left1.y() < camera.height - 1.0)) {
      return;
    }
    const double focal_baseline = camera.fx * camera.baseline_m;
    match.disparity0 = focal_baseline / depth + disparity_noise_ * random_.normal();
    match.disparity1 = seen.z() + disparity_noise_ * random_.normal();
    const double stated = flow_noise_ * std::exp(0.3 * random_.normal());
    match.flow_information = Eigen::Matrix2d::Identity() / (stated * stated);
    match.disparity0_information = 1.0 / (disparity_noise_ * disparity_noise_);
    match.disparity1_information = match.disparity0_information;
    match.weight = weights_vary_ ? random_.uniform(0.3, 1.0) : 1.0;
    field_.correspondences.push_back(match);
  }

  const FlowFieldOptions& options_;
  Random& random_;
  Carrier carrier_;
  FlowScene::Kind kind_;
  FlowScene scene_;
  lie::SO3d R_world_left_;
  FlowField field_;
  std::vector<Vector3d> moved_;  ///< per object, in the first camera's axes
  bool sky_ = false;             ///< clouds and skyline are matched too
  bool weights_vary_ = false;
  double flow_noise_ = 0.0;
  double disparity_noise_ = 0.0;
};

}  // namespace

void FlowFieldOptions::describe(Config& config) {
  config.field("seed", seed, "of cameras, scenes, motions and matches");
  config.field("least_points", least_points, "before holes");
  config.field("most_points", most_points, "before holes");
  config.field("least_noise", least_noise, "of the flow, standard deviation [px]");
  config.field("most_noise", most_noise, "of the flow, standard deviation [px]");
  config.field("most_outliers", most_outliers, "share, in the fields that have any [1]");
  config.field("with_outliers", with_outliers, "share of the fields [1]");
  config.field("with_movers", with_movers, "share of the fields where things move [1]");
  config.field("standing_still", standing_still, "share of the fields without translation [1]");
}

void FlowFieldOptions::validate() const {
  require_within("train.flow.least_points", least_points, 10, 1e5);
  require_within("train.flow.most_points", most_points, least_points, 1e5);
  require_within("train.flow.least_noise", least_noise, 1e-6, 100.0);
  require_within("train.flow.most_noise", most_noise, least_noise, 100.0);
  require_within("train.flow.most_outliers", most_outliers, 0.0, 0.9);
  require_within("train.flow.with_outliers", with_outliers, 0.0, 1.0);
  require_within("train.flow.with_movers", with_movers, 0.0, 1.0);
  require_within("train.flow.standing_still", standing_still, 0.0, 1.0);
}

FlowFieldGenerator::FlowFieldGenerator(const FlowFieldOptions& options) : options_(options) {
  options_.validate();
}

FlowField FlowFieldGenerator::make(std::uint64_t index) const {
  Random random = Random(static_cast<std::uint64_t>(options_.seed)).fork(index);
  return FieldMaker(options_, random).make();
}

}  // namespace imslam::training
