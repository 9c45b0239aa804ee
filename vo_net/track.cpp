#include "vo_net/track.hpp"

#include <Eigen/LU>

namespace imslam::vo {
namespace {

constexpr double kMinPredictDisparity = 0.1;  // [px] nearer infinity only the rotation counts

double information(double variance, double sigma_floor) {
  return 1.0 / (variance + sigma_floor * sigma_floor);
}

}  // namespace

Eigen::Vector3d predict(const StereoCamera& camera,
                        const Track& track,
                        const lie::SE3d& T_left1_left0) {
  const double d = std::max(track.disparity.value, kMinPredictDisparity);
  const Eigen::Vector3d uvd(track.left.x(), track.left.y(), d);
  const Eigen::Vector3d p = T_left1_left0 * camera.back_project(uvd);
  return p.z() > 0.1 ? camera.project(p) : uvd;
}

Correspondence make_correspondence(const Track& before,
                                   const Arrival& left1,
                                   const Track& now,
                                   double sigma_floor) {
  Correspondence c;
  c.left0 = before.left;
  c.left1 = left1.left;
  c.disparity0 = before.disparity.value;
  c.disparity1 = now.disparity.value;
  const double floor = sigma_floor * sigma_floor;
  const Eigen::Matrix2d covariance = left1.covariance + floor * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d inverse = covariance.inverse();
  c.flow_information = 0.5 * (inverse + inverse.transpose());
  c.disparity0_information = information(before.disparity.variance, sigma_floor);
  c.disparity1_information = information(now.disparity.variance, sigma_floor);
  c.weight = std::min({before.confidence, left1.confidence, now.confidence});
  c.track_id = before.id;
  c.learned = {left1.learned, before.disparity.learned, now.disparity.learned};
  return c;
}

StereoPoint make_stereo_point(const Track& track, double sigma_floor) {
  return {track.left, track.disparity.value, information(track.disparity.variance, sigma_floor),
          track.disparity.row_error, track.id};
}

void erase_tracks(std::vector<Track>& tracks, const std::vector<std::int64_t>& ids) {
  std::vector<std::int64_t> sorted = ids;
  std::sort(sorted.begin(), sorted.end());
  const auto is_erased = [&](const Track& track) {
    return std::binary_search(sorted.begin(), sorted.end(), track.id);
  };
  tracks.erase(std::remove_if(tracks.begin(), tracks.end(), is_erased), tracks.end());
}

}  // namespace imslam::vo
