#include "vo_net/match_replay.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "slam/base/error.hpp"
#include "vo_net/network_pixels.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;

/// The four images side by side [4,h,w,1].
template <typename S>
Var pixels_of(nn::Tape<S>& tape, const ReplayImages& images) {
  const std::array<const GrayImage*, 4> all{images.left0, images.right0, images.left1,
                                            images.right1};
  const int shrink = images.search.shrink;
  for (const GrayImage* const image : all) {
    expects(image != nullptr && image->width == all[0]->width && image->height == all[0]->height &&
                image->width >= shrink && image->height >= shrink,
            "replay_match: four images of one size");
  }
  const Index height = all[0]->height / shrink;
  const Index width = all[0]->width / shrink;
  const Var pixels = tape.make({4, height, width, 1});
  for (std::size_t i = 0; i < all.size(); ++i) {
    write_network_pixels(*all[i], shrink, height, width,
                         tape.data(pixels) + static_cast<Index>(i) * height * width);
  }
  return pixels;
}

/// Points [1,P,2] in pixels of the network.
template <typename S, typename PointOf>
Var points_of(nn::Tape<S>& tape,
              const Correspondences& correspondences,
              int shrink,
              const PointOf& point_of) {
  const Var points = tape.make({1, static_cast<Index>(correspondences.size()), 2});
  S* to = tape.data(points);
  for (const Correspondence& c : correspondences) {
    const Eigen::Vector2d place =
        (point_of(c).array() - network_origin(shrink)) / static_cast<double>(shrink);
    *to++ = static_cast<S>(place.x());
    *to++ = static_cast<S>(place.y());
  }
  return points;
}

double sigmoid(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

/// Numbers of one prediction, point by point.
template <typename S>
struct Reader {
  const nn::Tape<S>& tape;
  const MatchPrediction& said;
  double shrink;

  double moved(Index i) const { return shrink * number(said.displacement, i); }
  double scale(Index i) const { return shrink * std::exp(number(said.log_sigma, i)); }
  double correlation(Index i) const { return number(said.correlation, i); }
  double confidence(Index i) const { return sigmoid(number(said.confidence, i)); }

 private:
  double number(Var v, Index i) const { return static_cast<double>(tape.data(v)[i]); }
};

template <typename S>
void set_flow(const Reader<S>& flow, Index i, double sigma_floor, Correspondence& c) {
  c.left1 = c.left0 + Eigen::Vector2d(flow.moved(2 * i), flow.moved(2 * i + 1));
  const double sx = flow.scale(2 * i);
  const double sy = flow.scale(2 * i + 1);
  const double across = kVarianceOfScale * flow.correlation(i) * sx * sy;
  Eigen::Matrix2d covariance;
  covariance << kVarianceOfScale * sx * sx, across, across, kVarianceOfScale * sy * sy;
  covariance += sigma_floor * sigma_floor * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d inverse = covariance.inverse();
  c.flow_information = 0.5 * (inverse + inverse.transpose());
}

template <typename S>
void set_disparity(
    const Reader<S>& stereo, Index i, double sigma_floor, double& disparity, double& information) {
  disparity = -stereo.moved(i);
  const double sigma = stereo.scale(i);
  information = 1.0 / (kVarianceOfScale * sigma * sigma + sigma_floor * sigma_floor);
}

}  // namespace

template <typename S>
ReplayedMatch replay_match(nn::Tape<S>& tape,
                           MatchNetwork<S>& network,
                           const ReplayImages& images,
                           const Correspondences& correspondences) {
  const int shrink = images.search.shrink;
  const FeaturePyramid all = network.encode(tape, pixels_of(tape, images));
  const FeaturePyramid left0 = sample_of(tape, all, 0);
  const FeaturePyramid left1 = sample_of(tape, all, 2);
  const Var at_left0 =
      points_of(tape, correspondences, shrink, [](const Correspondence& c) { return c.left0; });
  const Var at_left1 =
      points_of(tape, correspondences, shrink, [](const Correspondence& c) { return c.left1; });
  MatchHint hint;
  hint.predicted_x = images.search.predicted.x() / shrink;
  hint.predicted_y = images.search.predicted.y() / shrink;
  ReplayedMatch match;
  match.shrink = shrink;
  match.flow = network.forward(tape, left0, left1, at_left0, MatchKind::kFlow, hint);
  match.stereo0 =
      network.forward(tape, left0, sample_of(tape, all, 1), at_left0, MatchKind::kStereo);
  match.stereo1 =
      network.forward(tape, left1, sample_of(tape, all, 3), at_left1, MatchKind::kStereo);
  return match;
}

template <typename S>
Correspondences replayed(const nn::Tape<S>& tape,
                         const ReplayedMatch& match,
                         const Correspondences& correspondences,
                         double sigma_floor) {
  const double shrink = match.shrink;
  const Reader<S> flow{tape, match.flow.prediction, shrink};
  const Reader<S> stereo0{tape, match.stereo0.prediction, shrink};
  const Reader<S> stereo1{tape, match.stereo1.prediction, shrink};
  Correspondences now = correspondences;
  for (std::size_t k = 0; k < now.size(); ++k) {
    const auto i = static_cast<Index>(k);
    Correspondence& c = now[k];
    if (c.learned.left1) set_flow(flow, i, sigma_floor, c);
    if (c.learned.disparity0) {
      set_disparity(stereo0, i, sigma_floor, c.disparity0, c.disparity0_information);
    }
    if (c.learned.disparity1) {
      set_disparity(stereo1, i, sigma_floor, c.disparity1, c.disparity1_information);
    }
    c.weight = std::min({stereo0.confidence(i), flow.confidence(i), stereo1.confidence(i)});
  }
  return now;
}

#define INSTANTIATE(S)                                                                     \
  template ReplayedMatch replay_match(nn::Tape<S>&, MatchNetwork<S>&, const ReplayImages&, \
                                      const Correspondences&);                             \
  template Correspondences replayed(const nn::Tape<S>&, const ReplayedMatch&,              \
                                    const Correspondences&, double);
INSTANTIATE(float)
INSTANTIATE(double)

}  // namespace imslam::vo
