#pragma once

#include <string>

#include "vo_net/conv_block.hpp"
#include "vo_net/level_match.hpp"
#include "vo_net/match_options.hpp"

namespace imslam::vo {

/// A whole number of cells.
struct CellShift {
  int x = 0;
  int y = 0;
};

/// The first guess, from all of the image at 1/16: a correlation volume, corrected by convolutions
/// that see what the neighbours say and what is depicted.
///
///   c = <f0(p), f1(p + shift + d)> for all d of the window    0 outside of the image
///   logits = e^sharpness c + decoder([c, f0])                 [N,h,w,K]
///   decoder: 3x3, 3x3 dilated 2, 3x3, each with norm and ReLU, then 1x1 that starts at 0
///
/// Points read the logits between the cells. Searching around a shift is the same as searching a
/// shifted image: the answer moves along.
template <typename S>
struct CoarseMatcher {
  static constexpr int kStride = 16;

  CoarseMatcher() = default;
  CoarseMatcher(const MatchNetworkOptions& options, MatchKind kind, Random& random);

  /// f0, f1 [N,h,w,C] unit features at 1/16, points [N,P,2] (x, y) [px of image 0]; `dense`: what
  /// logits() said for this shift, or none
  LevelMatch forward(nn::Tape<S>& tape,
                     nn::Var f0,
                     nn::Var f1,
                     nn::Var points,
                     const CellShift& shift,
                     nn::Var dense = {});
  /// The same for all cells [N,h,w,K].
  nn::Var logits(nn::Tape<S>& tape, nn::Var f0, nn::Var f1, const nn::Window& shifted);
  nn::Window shifted_window(const CellShift& shift) const {
    return {window.x_min + shift.x, window.x_max + shift.x, window.y_min + shift.y,
            window.y_max + shift.y, window.step};
  }

  void collect(nn::ParameterList<S>& list, const std::string& prefix);
  void fold();
  void freeze_norms(bool frozen);

  nn::Window window;
  nn::Parameter<S> sharpness;  ///< [1]
  ConvBlock<S> first;
  ConvBlock<S> second;
  ConvBlock<S> third;
  nn::Conv2d<S> correction;
};

}  // namespace imslam::vo
