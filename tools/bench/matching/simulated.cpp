#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "datasets/calibration_yaml.hpp"
#include "datasets/open_sequence.hpp"
#include "datasets/simulation/lens.hpp"
#include "slam/base/error.hpp"
#include "tools/bench/matching/true_visibility.hpp"
#include "tools/bench/matching/truth_files.hpp"
#include "tools/bench/matching/yardsticks.hpp"

namespace imslam::bench {
namespace {

namespace fs = std::filesystem;
using datasets::RawCamera;
using training::MatchState;
using vo::MatchKind;

constexpr float kOneSurface = 1.05F;  // ratio of depths
constexpr float kOneMotion = 1.0F;    // [px] difference of displacements

simulation::Lens lens_of(const RawCamera& camera) {
  std::array<double, 4> coefficients{};
  std::copy_n(camera.distortion.begin(), std::min<std::size_t>(4, camera.distortion.size()),
              coefficients.begin());
  const auto model = camera.lens == datasets::LensModel::kEquidistant
                         ? simulation::Distortion::kEquidistant
                         : simulation::Distortion::kRadTan;
  return {model,
          camera.width,
          camera.height,
          {camera.fx, camera.fy, camera.cx, camera.cy},
          coefficients};
}

/// The four pixels around a place and their bilinear weights.
struct Corners {
  Corners(const Eigen::Vector2d& place, int width, int height)
      : column(static_cast<int>(std::floor(place.x()))),
        row(static_cast<int>(std::floor(place.y()))),
        inside(column >= 0 && row >= 0 && column + 1 < width && row + 1 < height) {
    const auto fx = static_cast<float>(place.x() - column);
    const auto fy = static_cast<float>(place.y() - row);
    weights = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  }
  template <typename Image>
  auto of(const Image& image) const {
    return std::array{image.at(row, column), image.at(row, column + 1), image.at(row + 1, column),
                      image.at(row + 1, column + 1)};
  }
  int column, row;
  bool inside;
  std::array<float, 4> weights;
};

std::optional<float> depth_at(const TruthImage<float, 1>& depth, const Corners& corners) {
  float nearest = INFINITY;
  float farthest = 0.0F;
  float inverse = 0.0F;
  const auto depths = corners.of(depth);
  for (std::size_t i = 0; i < 4; ++i) {
    const float d = depths[i][0];
    if (!(d > 0.0F)) return std::nullopt;  // sky
    nearest = std::min(nearest, d);
    farthest = std::max(farthest, d);
    inverse += corners.weights[i] / d;
  }
  if (farthest > kOneSurface * nearest) return std::nullopt;
  return 1.0F / inverse;
}

std::optional<Eigen::Vector2d> flow_at(const TruthImage<std::uint16_t, 3>& flow,
                                       const Corners& corners) {
  const auto values = corners.of(flow);
  const auto displacement = [&](std::size_t i) {
    return Eigen::Vector2f(decoded_flow(values[i][2]), decoded_flow(values[i][1]));
  };
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    if (values[i][0] == 0) return std::nullopt;
    if ((displacement(i) - displacement(0)).norm() > kOneMotion) return std::nullopt;
    mean += corners.weights[i] * displacement(i);
  }
  return mean.cast<double>();
}

/// Carries truth of the raw left camera to its rectified image.
class Rectified {
 public:
  Rectified(const RawCamera& raw, const StereoCamera& camera)
      : lens_(lens_of(raw)),
        camera_(camera),
        R_raw_rectified_((raw.T_body_camera.inverse() * camera.T_body_left).rotation()) {}

  struct Ray {
    Eigen::Vector2d raw;        ///< [px]
    Eigen::Vector3d direction;  ///< in the raw camera, z = 1 in the rectified one
  };
  std::optional<Ray> ray(double u, double v) const {
    const Eigen::Vector3d direction =
        R_raw_rectified_ *
        Eigen::Vector3d((u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy, 1.0);
    const auto raw = lens_.project(direction);
    if (!raw) return std::nullopt;
    return Ray{*raw, direction};
  }
  double disparity(const Ray& ray, double raw_depth_m) const {
    return camera_.fx * camera_.baseline_m * ray.direction.z() / raw_depth_m;
  }
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& raw) const {
    const Eigen::Vector3d p = R_raw_rectified_.inverse() * lens_.direction(raw);
    if (p.z() <= 0.0) return std::nullopt;
    return Eigen::Vector2d(camera_.fx * p.x() / p.z() + camera_.cx,
                           camera_.fy * p.y() / p.z() + camera_.cy);
  }

 private:
  simulation::Lens lens_;
  StereoCamera camera_;
  lie::SO3d R_raw_rectified_;
};

void add_truth(const fs::path& mav0,
               const std::string& file,
               const Rectified& rectified,
               MatchScene& scene) {
  const TruthImage<float, 1> depth = read_float_png(mav0 / "depth0" / "data" / file);
  const TruthImage<std::uint16_t, 3> flow = read_uint16x3_png(mav0 / "flow0" / "data" / file);
  training::Triplet& t = scene.views;
  for (int row = 0; row < t.camera.height; ++row) {
    for (int column = 0; column < t.camera.width; ++column) {
      const auto ray = rectified.ray(column, row);
      if (!ray) continue;
      const Corners corners(ray->raw, depth.width, depth.height);
      if (!corners.inside) continue;
      const std::size_t at = t.index(row, column);
      if (const auto depth_m = depth_at(depth, corners)) {
        t.disparity[at] = static_cast<float>(rectified.disparity(*ray, double{*depth_m}));
        t.disparity_state[at] = MatchState::kVisible;
      }
      const auto moved = flow_at(flow, corners);
      const auto pixel1 = moved ? rectified.pixel(ray->raw + *moved) : std::nullopt;
      if (!pixel1) continue;
      t.flow_u[at] = static_cast<float>(pixel1->x() - column);
      t.flow_v[at] = static_cast<float>(pixel1->y() - row);
      t.flow_state[at] = MatchState::kVisible;
    }
  }
  mark_hidden(MatchKind::kStereo, scene);
  mark_hidden(MatchKind::kFlow, scene);
}

MatchScene read_scene(const fs::path& mav0,
                      const Rectified& rectified,
                      std::size_t index,
                      datasets::Sequence& sequence) {
  const StereoFrame frame = sequence.read_frame(index);
  const StereoFrame next = sequence.read_frame(index + 1);
  if (!frame.complete() || next.left.empty()) {
    throw InputError(
        fmt::format("{}: image {} or its successor is missing", sequence.root().string(), index));
  }
  MatchScene scene = scene_around(fmt::format("{}", index), frame.left);
  scene.views.right0 = view_of(scene, frame.right);
  scene.views.left1 = view_of(scene, next.left);
  scene.has_stereo = scene.has_flow = true;
  add_truth(mav0, fmt::format("{}.png", frame.time_ns), rectified, scene);
  return scene;
}

}  // namespace

std::vector<MatchScene> read_simulated(const fs::path& folder, int frames) {
  const fs::path mav0 = folder / "mav0";
  const auto sequence = datasets::open_sequence(folder, "euroc");
  if (!fs::is_directory(mav0 / "depth0") || !fs::is_directory(mav0 / "flow0")) {
    throw InputError(folder.string() +
                     ": expected depth0 and flow0; simulate with truth_depth and truth_flow");
  }
  const Rectified rectified(datasets::read_euroc_camera(mav0 / "cam0" / "sensor.yaml"),
                            sequence->camera());
  std::vector<MatchScene> scenes;
  const int available = static_cast<int>(sequence->frame_count()) - 1;
  for (const int index : evenly_spread(available, frames)) {
    scenes.push_back(read_scene(mav0, rectified, static_cast<std::size_t>(index), *sequence));
  }
  return scenes;
}

}  // namespace imslam::bench
