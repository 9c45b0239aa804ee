#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "slam/sensors/stereo.hpp"
#include "vo_net/match_network.hpp"

namespace imslam::vo {

/// What the network says about one point, in pixels of the full image.
struct NetworkAnswer {
  Eigen::Vector2d displacement = Eigen::Vector2d::Zero();    ///< stereo: (-disparity, 0)
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< stereo: of x; y is not measured
  double confidence = 0.0;                                   ///< [1] that it is right
};

/// Runs the matching network over a stereo sequence: each image is encoded once.
///
///   advance(left, right)    encodes both, side by side; the left image before is kept
///   flow(points)            left before -> left
///   stereo(points)          left -> right
///
/// The network's errors have Student's t distribution with 3 degrees of freedom; the covariances
/// here are those of the distribution, 3 times the squared scale. Allocates nothing but the answers
/// from the second pair on, if there are not more points than ever before.
class MatchInference {
 public:
  /// The network must be folded or frozen: it is only read.
  explicit MatchInference(std::shared_ptr<MatchNetwork<float>> network);

  /// Images of one size, throughout; not smaller than shrink x shrink. The network sees means of
  /// shrink x shrink pixels; if that was another number before, the left image before is encoded
  /// anew.
  void advance(const GrayImage& left, const GrayImage& right, int shrink);

  /// The left image before is the newest one again. Once per advance().
  void step_back();

  /// `predicted` [px]: where to search, see MatchHint. After two pairs.
  std::vector<NetworkAnswer> flow(const std::vector<Eigen::Vector2d>& points,
                                  const Eigen::Vector2d& predicted);
  std::vector<NetworkAnswer> stereo(const std::vector<Eigen::Vector2d>& points);

 private:
  /// Where one image is encoded and then matched.
  struct Encoded {
    GrayImage image;
    int shrink = 0;  ///< that it is encoded with; 0: it is not
    nn::Tape<float> tape{nn::Mode::kInference};
    FeaturePyramid features;
  };

  /// Two encoded images and what does not depend on the points between them.
  struct Pair {
    const Encoded& from;
    Encoded& to;
    nn::Var coarse_logits;  ///< on the tape of `to`
    MatchKind kind;
    MatchHint hint;
  };
  void encode(Encoded& encoded) const;
  nn::Var coarse_logits(const FeaturePyramid& from,
                        Encoded& to,
                        MatchKind kind,
                        const MatchHint& hint);
  std::vector<NetworkAnswer> match(const Pair& pair, const std::vector<Eigen::Vector2d>& points);
  void match_some(const Pair& pair,
                  nn::Tape<float>& tape,
                  const Eigen::Vector2d* points,
                  nn::Index count,
                  NetworkAnswer* answers) const;

  std::shared_ptr<MatchNetwork<float>> network_;
  int shrink_ = 1;
  std::unique_ptr<Encoded> left_before_;
  std::unique_ptr<Encoded> left_;
  std::unique_ptr<Encoded> right_;
  nn::Var stereo_logits_;  ///< on the tape of right_, or none yet
  std::vector<std::unique_ptr<nn::Tape<float>>> point_tapes_;  ///< one per some of the points
};

}  // namespace imslam::vo
