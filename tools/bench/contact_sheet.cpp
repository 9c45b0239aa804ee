#include "tools/bench/contact_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "slam/base/error.hpp"

namespace imslam::bench {
namespace {

using training::MatchState;
using training::Triplet;

cv::Mat3b grey_picture(const Triplet& triplet, const std::vector<float>& grey) {
  cv::Mat3b picture(triplet.camera.height, triplet.camera.width);
  for (std::size_t i = 0; i < grey.size(); ++i)
    *(picture.begin() + static_cast<int>(i)) = cv::Vec3b::all(cv::saturate_cast<uchar>(grey[i]));
  return picture;
}

cv::Mat3b disparity_picture(const Triplet& triplet) {
  const float most = *std::max_element(triplet.disparity.begin(), triplet.disparity.end());
  std::vector<float> scaled = triplet.disparity;
  for (float& value : scaled) value *= 255.0F / most;
  return grey_picture(triplet, scaled);
}

cv::Mat3b flow_picture(const Triplet& triplet) {
  cv::Mat3b picture(triplet.camera.height, triplet.camera.width);
  for (std::size_t i = 0; i < triplet.flow_u.size(); ++i) {
    const double hue = std::atan2(triplet.flow_v[i], triplet.flow_u[i]) / M_PI * 90.0 + 90.0;
    const double size = std::hypot(triplet.flow_u[i], triplet.flow_v[i]);
    *(picture.begin() + static_cast<int>(i)) =
        cv::Vec3b(cv::saturate_cast<uchar>(std::min(hue, 179.0)),
                  cv::saturate_cast<uchar>(255.0 * std::min(1.0, size / 40.0)), 255);
  }
  cv::cvtColor(picture, picture, cv::COLOR_HSV2BGR);
  return picture;
}

uchar brightness(MatchState state) { return static_cast<uchar>(85 * static_cast<int>(state)); }

cv::Mat3b state_picture(const Triplet& triplet) {
  cv::Mat3b picture(triplet.camera.height, triplet.camera.width);
  for (std::size_t i = 0; i < triplet.flow_state.size(); ++i) {
    *(picture.begin() + static_cast<int>(i)) =
        cv::Vec3b(0, brightness(triplet.flow_state[i]), brightness(triplet.disparity_state[i]));
  }
  return picture;
}

}  // namespace

void write_contact_sheet(const std::vector<Triplet>& triplets, const std::string& file) {
  cv::Mat3b sheet;
  for (const Triplet& triplet : triplets) {
    const std::vector<cv::Mat3b> pictures{grey_picture(triplet, triplet.left0),
                                          grey_picture(triplet, triplet.right0),
                                          grey_picture(triplet, triplet.left1),
                                          disparity_picture(triplet),
                                          flow_picture(triplet),
                                          state_picture(triplet)};
    cv::Mat3b row;
    cv::hconcat(pictures, row);
    sheet.push_back(row);
  }
  if (!cv::imwrite(file, sheet))
    throw InputError(file + ": cannot be written; choose a folder that exists, and .png",
                     ExitCode::kOutput);
}

}  // namespace imslam::bench
