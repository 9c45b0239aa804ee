#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/sensors/stereo.hpp"
#include "vo_net/match_options.hpp"

namespace imslam::bench {

/// What a network says about its own answer.
struct StatedUncertainty {
  /// [px^2] of a t distribution with 3 degrees of freedom; stereo: only (0, 0) means something.
  Eigen::Matrix2d scale = Eigen::Matrix2d::Identity();
  double confidence = 0.0;  ///< [0, 1]
};

struct PointMatch {
  bool answered = false;
  bool accepted = false;
  double score = 0.0;                                      ///< the greater, the surer
  Eigen::Vector2d displacement = Eigen::Vector2d::Zero();  ///< [px] stereo: (-disparity, any)
  std::optional<StatedUncertainty> uncertainty;
};

/// One row of the tables.
struct Answer {
  std::string method;
  std::vector<PointMatch> matches;  ///< one per query point
};

/// Finds query points of one image in another, without any prediction. Used by several threads at
/// once.
class Method {
 public:
  virtual ~Method() = default;
  virtual std::vector<std::string> names(vo::MatchKind kind) const = 0;  ///< of its answers
  virtual std::vector<Answer> match(vo::MatchKind kind,
                                    const GrayImage& image0,
                                    const GrayImage& image1,
                                    const std::vector<Eigen::Vector2d>& points) const = 0;
};

inline constexpr const char* kKltName = "KLT";

/// Our KLT with its default options, as vo::KltMatcher uses it but from where the point was.
/// Stands by what passes correlation and the way back; score: -variance.
std::unique_ptr<Method> make_klt();

/// OpenCV's DIS flow, preset medium; for stereo its u is taken. Stands by everything; score:
/// -distance to where the way back leads.
std::unique_ptr<Method> make_dis();

/// OpenCV's StereoSGBM (3-way), stereo only: blocks of 5 px, disparities 0 to 191 px. Stands by
/// what passes uniqueness (10 %), left-right check (1 px) and speckle filter; score: -difference of
/// the disparities that left and right view are given.
std::unique_ptr<Method> make_sgbm();

/// The matching network with default options and the weights of a safetensors file. Two answers:
/// "network" stands by a stated confidence above 0.5, which is also its score; "network+LK" is the
/// same after Lucas-Kanade at full size, where that moves by less than 1.5 px and the network's
/// scale is below 1 px. InputError(kModel) for a bad file.
std::unique_ptr<Method> make_network(const std::filesystem::path& weights);

}  // namespace imslam::bench
