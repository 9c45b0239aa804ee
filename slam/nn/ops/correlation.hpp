#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// A grid of displacements around a pixel [pixels], x fastest. Stereo searches to one side:
/// {-24, 1, -1, 1}.
struct Window {
  int x_min = 0;
  int x_max = 0;  ///< included
  int y_min = 0;
  int y_max = 0;  ///< included
  int step = 1;

  static Window square(int radius, int step = 1) {
    return {-radius, radius, -radius, radius, step};
  }
  int columns() const { return (x_max - x_min) / step + 1; }
  int rows() const { return (y_max - y_min) / step + 1; }
  int count() const { return columns() * rows(); }
  int x(int k) const { return x_min + (k % columns()) * step; }
  int y(int k) const { return y_min + (k / columns()) * step; }
  void validate() const;
};

/// How well each pixel of a fits to the pixels around it in b.
///
///   a, b [N,H,W,C]    y [N,H,W,K]    K = window.count()
///   y[p, k] = <a[p], b[p + d_k]>                         0 outside of b
///   backward   da[p] += sum_k dy[p, k] b[p + d_k]        db[q] += sum_k dy[q - d_k, k] a[q - d_k]
///
/// With l2-normalised features that is the cosine.
template <typename S>
Var cost_volume(Tape<S>& tape, Var a, Var b, const Window& window);

/// Where the windows of correlate_points stand.
enum class Centre {
  kRounded,   ///< on the pixel nearest to the centre: no gradient to centres
  kBilinear,  ///< on the centre itself, b read between pixels; step 1 only
};

/// The same for single points with centres of their own.
///
///   query [N,P,C]    b [N,H,W,C]    centres [N,P,2] (x, y) [pixels]    y [N,P,K]
///   y[p, k] = <query[p], b(centre[p] + d_k)>    0 outside of b and for centres that are not finite
///
/// Reading b between pixels commutes with the product, so bilinear windows are the (K + border)
/// whole products mixed four by four.
template <typename S>
Var correlate_points(
    Tape<S>& tape, Var query, Var b, Var centres, const Window& window, Centre centre);

}  // namespace imslam::nn
