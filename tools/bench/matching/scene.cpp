#include "tools/bench/matching/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "datasets/image_io.hpp"
#include "slam/base/error.hpp"

namespace imslam::bench {
namespace {

using training::MatchState;
using vo::MatchKind;

std::vector<float> upper_left(const GrayImage& image, int width, int height) {
  std::vector<float> view;
  view.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int row = 0; row < height; ++row) {
    const std::uint8_t* pixels = image.pixels.data() + std::ptrdiff_t{row} * image.width;
    view.insert(view.end(), pixels, pixels + width);
  }
  return view;
}

}  // namespace

TrueMatch true_match(const MatchScene& scene, MatchKind kind, int row, int column) {
  const training::Triplet& t = scene.views;
  const std::size_t at = t.index(row, column);
  if (kind == MatchKind::kFlow) {
    return {t.flow_state[at], double{t.flow_u[at]}, double{t.flow_v[at]}};
  }
  return {t.disparity_state[at], -double{t.disparity[at]}, 0.0};
}

const std::vector<float>& matched_view(const MatchScene& scene, MatchKind kind) {
  return kind == MatchKind::kFlow ? scene.views.left1 : scene.views.right0;
}

GrayImage gray_image(const MatchScene& scene, const std::vector<float>& view) {
  GrayImage image{scene.views.camera.width, scene.views.camera.height, {}};
  image.pixels.resize(view.size());
  std::transform(view.begin(), view.end(), image.pixels.begin(), [](float grey) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
  });
  return image;
}

GrayImage read_gray(const std::filesystem::path& image) {
  datasets::DecodedImage decoded = datasets::ImageDecoder().decode(image, std::nullopt);
  if (decoded.image.empty()) {
    throw InputError(fmt::format("{}: expected an image, but it is {}; is the data complete?",
                                 image.string(), decoded.fault));
  }
  return std::move(decoded.image);
}

MatchScene scene_around(const std::string& name, const GrayImage& left0) {
  MatchScene scene;
  scene.name = name;
  training::Triplet& t = scene.views;
  t.camera.width = left0.width / 16 * 16;
  t.camera.height = left0.height;
  t.left0 = upper_left(left0, t.camera.width, t.camera.height);
  t.right0 = t.left1 = t.left0;
  t.disparity.assign(t.left0.size(), 0.0F);
  t.flow_u = t.flow_v = t.disparity;
  t.disparity_state.assign(t.left0.size(), MatchState::kNone);
  t.flow_state = t.disparity_state;
  return scene;
}

std::vector<float> view_of(const MatchScene& scene, const GrayImage& image) {
  const StereoCamera& camera = scene.views.camera;
  if (image.width < camera.width || image.height != camera.height) {
    throw InputError(fmt::format("{}: a view of {} x {} px, but its partner has {} rows",
                                 scene.name, image.width, image.height, camera.height));
  }
  return upper_left(image, camera.width, camera.height);
}

void expect_truth_size(const MatchScene& scene,
                       int width,
                       int height,
                       const std::filesystem::path& file) {
  if (width >= scene.views.camera.width && height == scene.views.camera.height) return;
  throw InputError(
      fmt::format("{}: {} x {} px, not as large as its image", file.string(), width, height));
}

std::vector<int> evenly_spread(int available, int wanted) {
  const int count = std::min(available, wanted);
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(i * available / count);
  return numbers;
}

const char* kind_name(MatchKind kind) { return kind == MatchKind::kFlow ? "flow" : "disparity"; }

}  // namespace imslam::bench
