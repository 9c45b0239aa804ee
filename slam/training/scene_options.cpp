#include <fmt/format.h>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/training/bounds.hpp"
#include "slam/training/layered_scene.hpp"

namespace imslam::training {
namespace {

void require(bool holds, const char* key, double value, const char* bound) {
  if (holds) return;
  throw InputError(fmt::format("scene.{}: expected {}, got {}", key, bound, value),
                   ExitCode::kUsage);
}

}  // namespace

void SceneOptions::describe(Config& config) {
  config.field("width", width, "of the views, a multiple of 16 [px]");
  config.field("height", height, "of the views, a multiple of 16 [px]");
  config.field("least_disparity", least_disparity, "smallest disparity of the nearest thing [px]");
  config.field("most_disparity", most_disparity, "largest disparity of the nearest thing [px]");
  config.field("rotation_flow", rotation_flow, "most flow by turning the camera [px]");
  config.field("parallax_flow", parallax_flow, "most flow of the nearest thing by moving [px]");
  config.field("object_flow", object_flow, "sigma of the flow of moving things [px]");
  config.field("moving_share", moving_share, "share of cut-outs that move by themselves");
  config.field("still_share", still_share, "share of scenes whose camera rests");
}

void SceneOptions::validate() const {
  require_within("scene.width", width, 64, 2048);
  require_within("scene.height", height, 64, 2048);
  require(width % 16 == 0, "width", width, "a multiple of 16");
  require(height % 16 == 0, "height", height, "a multiple of 16");
  require_within("scene.least_disparity", least_disparity, 1.0, 512.0);
  require(most_disparity >= least_disparity && most_disparity <= 0.5 * width, "most_disparity",
          most_disparity, "least_disparity to half the width");
  require_within("scene.rotation_flow", rotation_flow, 0.0, 0.25 * width);
  require_within("scene.parallax_flow", parallax_flow, 0.0, 0.25 * width);
  require_within("scene.object_flow", object_flow, 0.0, 0.25 * width);
  require_within("scene.moving_share", moving_share, 0.0, 1.0);
  require_within("scene.still_share", still_share, 0.0, 1.0);
}

}  // namespace imslam::training
