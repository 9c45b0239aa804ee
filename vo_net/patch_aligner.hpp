#pragma once

#include <Eigen/Core>

#include "vo_net/image_pyramid.hpp"

namespace imslam::vo {

struct AlignOptions {
  int window = 15;          ///< [px] odd, at most 23: side of the patch at every level
  int max_iterations = 12;  ///< per level
  double precision = 0.01;  ///< [px] last step at full size
  double max_step = 2.0;    ///< [px] one step at most; a longer one points out of the linear range
  double smoothing = 0.0;   ///< [px] that the images were built with: makes neighbours' noise alike
};

/// Where a patch was found again.
struct Alignment {
  bool found = false;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< [px] at full size
  double correlation = 0.0;  ///< [-1, 1] of the patches after removing mean and contrast
  double gain = 1.0;         ///< contrast of the target over that of the template
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< [px^2] from noise and texture
};

/// A small window of one image, ready to be found in another one.
///
///   min over p, gain, offset of  sum_x (I(x + p) - gain T(x) - offset)^2
///
/// Lucas-Kanade in its inverse compositional form: the normal matrix belongs to the template and is
/// factored once, so that an iteration is one interpolation and four dot products. Gain and offset
/// are unknowns of every step: changes of exposure do not matter. Baker & Matthews,
/// "Lucas-Kanade 20 Years On", IJCV 2004, sections 2.2 and part 3 (appearance variation).
class PatchTemplate {
 public:
  /// Takes the patch around `center` [px of that level]; false if it has no texture.
  bool take(const ImagePyramid::Level& level, const Eigen::Vector2d& center, int window);

  /// Follows the patch in `level` from `start`; positions in px of that level.
  /// `along_row`: only u may change.
  Alignment align(const ImagePyramid::Level& level,
                  const Eigen::Vector2d& start,
                  const AlignOptions& options,
                  bool along_row) const;

  /// Correlation with the patch around a position.
  double correlation_at(const ImagePyramid::Level& level, const Eigen::Vector2d& position) const;

  static constexpr int kMaxWindow = 23;
  static constexpr int kLanes = 24;  // rows are padded with zeros to a multiple of 4

 private:
  struct Sums;
  Sums sums_at(const ImagePyramid::Level& level, const Eigen::Vector2d& position) const;
  Alignment finish(const Sums& sums,
                   const Eigen::Vector2d& position,
                   double smoothing,
                   bool along_row) const;

  bool factor_normal_matrix();

  using Rows = Eigen::Matrix<float, kLanes, kMaxWindow>;  // column r holds row r of the patch
  Rows x_;                                                // dT/dx
  Rows y_;                                                // dT/dy
  Rows value_;                                            // T - mean
  Eigen::Array<float, kLanes, 1> mask_;                   // 1 inside the window, 0 in the padding
  int window_ = 0;
  int lanes_ = 0;                 // window rounded up to a multiple of 4
  double mean_ = 0.0;             // of T, subtracted from both images
  double energy_ = 0.0;           // sum (T - mean)^2
  double count_ = 0.0;            // pixels
  Eigen::Matrix4d inverse_full_;  // inverse normal matrix of [dx dy gain offset]
  Eigen::Matrix3d inverse_row_;   // of [dx gain offset]
};

/// Coarse to fine from `start` (full size) to full size.
Alignment align_patch(const ImagePyramid& from,
                      const Eigen::Vector2d& center,
                      const ImagePyramid& to,
                      const Eigen::Vector2d& start,
                      int coarsest_level,
                      const AlignOptions& options,
                      bool along_row);

}  // namespace imslam::vo
