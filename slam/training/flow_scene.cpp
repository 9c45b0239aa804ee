#include "slam/training/flow_scene.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace imslam::training {
namespace {

constexpr double kNearest = 0.05;    // nothing is seen nearer
constexpr double kFarthest = 300.0;  // beyond it is sky

double log_uniform(double low, double high, Random& random) {
  return low * std::pow(high / low, random.uniform());
}

Eigen::Vector3d unit(Random& random) {
  Eigen::Vector3d v = random.normal3();
  while (!(v.norm() > 1e-3)) v = random.normal3();
  return v.normalized();
}

}  // namespace

FlowScene::FlowScene(Kind kind, Random& random) {
  if (kind == Kind::kRoom) add_room(random);
  if (kind == Kind::kStreet) add_street(random);
  if (kind == Kind::kGround) add_ground(random);
  if (kind == Kind::kRelief) add_relief(random);
  if (kind != Kind::kClutter) return;
  if (random.chance(0.7)) add_wall(Eigen::Vector3d::UnitY(), random.uniform(0.5, 3.0));
  add_objects(static_cast<int>(random.integer(15, 60)), 1.0, 40.0, random);
}

void FlowScene::add_relief(Random& random) {
  depth_ = log_uniform(1.0, 20.0, random);
  for (int i = 0; i < 4; ++i) {
    waves_.push_back({random.uniform(0.0, 0.4), random.uniform(-6.0, 6.0),
                      random.uniform(-6.0, 6.0), random.uniform(0.0, 6.28)});
  }
  add_objects(static_cast<int>(random.integer(0, 4)), 0.3 * depth_, depth_, random);
}

void FlowScene::add_wall(const Eigen::Vector3d& normal, double offset) {
  Plane wall;
  wall.normal = normal;
  wall.offset = offset;
  planes_.push_back(wall);
}

void FlowScene::add_room(Random& random) {
  const double size = log_uniform(1.0, 8.0, random);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d normal = Eigen::Vector3d::Unit(axis);
    const double share = axis == 1 ? 0.5 : 1.0;  // rooms are wider than high
    add_wall(normal, share * size * random.uniform(0.3, 1.5));
    add_wall(normal, -share * size * random.uniform(0.3, 1.5));
  }
  add_objects(static_cast<int>(random.integer(0, 14)), 0.25 * size, 1.2 * size, random);
}

void FlowScene::add_street(Random& random) {
  const double height = random.uniform(1.0, 2.5);
  add_wall(Eigen::Vector3d::UnitY(), height);
  for (const double side : {-1.0, 1.0}) {
    if (!random.chance(0.75)) continue;
    Plane facade;
    facade.normal = Eigen::Vector3d::UnitX();
    facade.offset = side * random.uniform(3.0, 18.0);
    facade.centre = {facade.offset, random.uniform(-6.0, 0.0), random.uniform(0.0, 30.0)};
    facade.across = Eigen::Vector3d::UnitZ();
    facade.half_across = random.uniform(10.0, 80.0);
    facade.half_along = random.uniform(2.0, 12.0);
    planes_.push_back(facade);
  }
  const auto count = static_cast<int>(random.integer(3, 20));
  for (int i = 0; i < count; ++i) {  // cars, trunks, posts stand on the ground
    const double radius = random.uniform(0.2, 1.6);
    const double side = random.chance(0.5) ? 1.0 : -1.0;
    balls_.push_back({{side * random.uniform(1.8, 14.0), height - radius * random.uniform(0.3, 2.5),
                       random.uniform(3.0, 50.0)},
                      radius,
                      object_count_++});
  }
}

void FlowScene::add_ground(Random& random) {
  const Eigen::Vector3d tilt{random.uniform(-0.4, 0.4), 0.0, random.uniform(-0.4, 0.4)};
  add_wall((Eigen::Vector3d::UnitY() + tilt).normalized(), log_uniform(0.7, 30.0, random));
  if (random.chance(0.5)) add_objects(static_cast<int>(random.integer(1, 8)), 1.0, 20.0, random);
}

void FlowScene::add_objects(int count, double nearest, double farthest, Random& random) {
  for (int i = 0; i < count; ++i) {
    const double distance = log_uniform(nearest, farthest, random);
    Eigen::Vector3d towards = unit(random);
    towards.z() = std::abs(towards.z()) + 0.5;  // more of them where the camera may look
    const Eigen::Vector3d centre = distance * towards.normalized();
    const double size = distance * random.uniform(0.05, 0.4);
    if (random.chance(0.5)) {
      balls_.push_back({centre, size, object_count_++});
      continue;
    }
    Plane board;
    board.normal = unit(random);
    board.centre = centre;
    board.offset = board.normal.dot(centre);
    board.across = board.normal.unitOrthogonal();
    board.half_across = size;
    board.half_along = size * random.uniform(0.3, 2.0);
    board.object = object_count_++;
    planes_.push_back(board);
  }
}

std::optional<SceneHit> FlowScene::cast(const Eigen::Vector3d& ray) const {
  SceneHit nearest;
  nearest.distance = kFarthest / ray.norm();
  bool found = false;
  const auto offer = [&](double distance, int object) {
    if (!(distance * ray.norm() > kNearest && distance < nearest.distance)) return;
    nearest = {distance, object};
    found = true;
  };
  for (const Plane& plane : planes_) {
    const double distance = plane.offset / plane.normal.dot(ray);
    if (plane.half_across > 0.0) {
      const Eigen::Vector3d from_centre = distance * ray - plane.centre;
      const Eigen::Vector3d along = plane.normal.cross(plane.across);
      if (!(std::abs(from_centre.dot(plane.across)) < plane.half_across &&
            std::abs(from_centre.dot(along)) < plane.half_along)) {
        continue;
      }
    }
    offer(distance, plane.object);
  }
  for (const Ball& ball : balls_) {
    const double along = ray.dot(ball.centre) / ray.squaredNorm();
    const double aside_sq = (along * ray - ball.centre).squaredNorm();
    const double inside_sq = ball.radius * ball.radius - aside_sq;
    if (inside_sq > 0.0) offer(along - std::sqrt(inside_sq / ray.squaredNorm()), ball.object);
  }
  if (depth_ > 0.0 && ray.z() > 0.05) {
    double exponent = 0.0;
    for (const Eigen::Vector4d& w : waves_) {
      exponent += w[0] * std::sin(w[1] * ray.x() / ray.z() + w[2] * ray.y() / ray.z() + w[3]);
    }
    offer(depth_ * std::exp(exponent) / ray.z(), -1);
  }
  if (!found) return std::nullopt;
  return nearest;
}

}  // namespace imslam::training
