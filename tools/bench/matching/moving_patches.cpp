#include "tools/bench/matching/moving_patches.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slam/base/error.hpp"
#include "slam/training/occluders.hpp"

namespace imslam::bench {
namespace {

using training::MatchState;
using training::Triplet;

constexpr double kPi = 3.14159265358979323846;

double in_quarters(double value) { return std::round(4.0 * value) / 4.0; }

/// The greatest known disparity under a patch [px].
double nearest_under(const MovingPatch& patch, const Triplet& t) {
  float nearest = 0.0F;
  for (int row = 0; row < patch.height; ++row) {
    for (int column = 0; column < patch.width; ++column) {
      const std::size_t at =
          t.index(static_cast<int>(patch.y) + row, static_cast<int>(patch.x) + column);
      if (t.disparity_state[at] != MatchState::kNone) nearest = std::max(nearest, t.disparity[at]);
    }
  }
  return double{nearest};
}

MovingPatch draw_patch(const MatchScene& scene, Random random) {
  const Triplet& t = scene.views;
  const auto side = [&] {
    return static_cast<int>(t.camera.width * random.uniform(0.7, 1.3) / 8.0);
  };
  const auto place = [&](int size, int extent) {
    return static_cast<int>(random.integer(0, size - extent));
  };
  MovingPatch patch;
  patch.width = side();
  patch.height = side();
  patch.x = place(t.camera.width, patch.width);
  patch.y = place(t.camera.height, patch.height);
  patch.source_x = place(t.camera.width, patch.width);
  patch.source_y = place(t.camera.height, patch.height);
  const double angle = random.uniform(0.0, 2.0 * kPi);
  const double length = random.uniform(4.0, 24.0);
  patch.flow_u = in_quarters(length * std::cos(angle));
  patch.flow_v = in_quarters(length * std::sin(angle));
  patch.disparity = in_quarters(nearest_under(patch, t) + random.uniform(1.0, 10.0));
  return patch;
}

/// The piece as it stands before the camera.
cv::Mat piece_of(const MovingPatch& patch, const Triplet& t) {
  const cv::Mat left0(t.camera.height, t.camera.width, CV_32F, const_cast<float*>(t.left0.data()));
  cv::Mat piece;
  cv::flip(left0(cv::Rect(patch.source_x, patch.source_y, patch.width, patch.height)), piece, 1);
  return piece;
}

/// Warps by exact quarters of a pixel (warpAffine counts in 1/32); at the border by covered area.
void draw(const cv::Mat& piece, double x, double y, std::vector<float>& pixels, const Triplet& t) {
  cv::Mat view(t.camera.height, t.camera.width, CV_32F, pixels.data());
  const cv::Matx23d shift(1.0, 0.0, x, 0.0, 1.0, y);
  cv::Mat moved;
  cv::Mat share;
  cv::warpAffine(piece, moved, shift, view.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  cv::warpAffine(cv::Mat::ones(piece.size(), CV_32F), share, shift, view.size(), cv::INTER_LINEAR,
                 cv::BORDER_CONSTANT, 0.0);
  moved = cv::max(cv::min(moved, 255.0), 0.0);
  view += share.mul(moved - view);
}

training::Occluder occluder_of(const MovingPatch& patch) {
  training::Occluder occluder;
  occluder.x = patch.x - 0.5;
  occluder.y = patch.y - 0.5;
  occluder.width = patch.width;
  occluder.height = patch.height;
  occluder.disparity = patch.disparity;
  occluder.flow_u = patch.flow_u;
  occluder.flow_v = patch.flow_v;
  return occluder;
}

}  // namespace

std::vector<MovingPatch> draw_patches(const MatchScene& scene, int count, const Random& random) {
  std::vector<MovingPatch> patches;
  for (int i = 0; i < count; ++i) {
    patches.push_back(draw_patch(scene, random.fork(static_cast<std::uint64_t>(i))));
  }
  return patches;
}

void add_patches(const std::vector<MovingPatch>& patches, MatchScene& scene) {
  Triplet& t = scene.views;
  std::vector<cv::Mat> pieces;
  for (const MovingPatch& patch : patches) pieces.push_back(piece_of(patch, t));
  std::vector<float> left0 = t.left0;
  std::vector<float> right0 = t.right0;
  std::vector<float> left1 = t.left1;
  std::vector<training::Occluder> occluders;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const MovingPatch& patch = patches[i];
    expects(patch.disparity > 0.0, "add_patches: disparity must be positive");
    draw(pieces[i], patch.x, patch.y, left0, t);
    draw(pieces[i], patch.x - patch.disparity, patch.y, right0, t);
    draw(pieces[i], patch.x + patch.flow_u, patch.y + patch.flow_v, left1, t);
    occluders.push_back(occluder_of(patch));
  }
  training::add_occluders(occluders, t);  // for the truth; its grey rectangles go
  t.left0 = std::move(left0);
  t.right0 = std::move(right0);
  t.left1 = std::move(left1);
}

}  // namespace imslam::bench
