#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slam/sensors/stereo.hpp"
#include "slam/training/triplet.hpp"
#include "vo_net/match_options.hpp"

namespace imslam::bench {

/// One instant of a yardstick: left and right view, the left view of the next instant, and where
/// the pixels of the left view really went.
///
/// All arrays of `views` have width * height entries. What a data set does not tell has the state
/// kNone everywhere, and the view it would need is a copy of left0. Of the camera only width and
/// height are set. Widths are cut on the right to a multiple of 16 px, as degrade() asks for.
struct MatchScene {
  std::string name;
  training::Triplet views;
  bool has_flow = false;
  bool has_stereo = false;

  bool has(vo::MatchKind kind) const {
    return kind == vo::MatchKind::kFlow ? has_flow : has_stereo;
  }
};

/// The truth of one kind; stereo has du = -disparity, dv = 0.
struct TrueMatch {
  training::MatchState state = training::MatchState::kNone;
  double du = 0.0, dv = 0.0;  ///< [px]
};
TrueMatch true_match(const MatchScene& scene, vo::MatchKind kind, int row, int column);

/// The view that left0 is matched with.
const std::vector<float>& matched_view(const MatchScene& scene, vo::MatchKind kind);
GrayImage gray_image(const MatchScene& scene, const std::vector<float>& view);

/// A PNG or JPEG file as grey levels. InputError if it cannot be read.
GrayImage read_gray(const std::filesystem::path& image);

/// A scene around the left image: the other views are its copies, nothing is known.
MatchScene scene_around(const std::string& name, const GrayImage& left0);

/// An image as a view of the scene. InputError naming the scene if the image is too small.
std::vector<float> view_of(const MatchScene& scene, const GrayImage& image);

/// Holds the size of a truth image against that of the scene. InputError naming the file.
void expect_truth_size(const MatchScene& scene,
                       int width,
                       int height,
                       const std::filesystem::path& file);

/// At most `wanted` of the numbers 0 .. available - 1, evenly spread, always with the first.
std::vector<int> evenly_spread(int available, int wanted);

const char* kind_name(vo::MatchKind kind);

}  // namespace imslam::bench
