#pragma once

namespace imslam::nn::kernels {

/// Taps of one phase along one axis: tap first_tap + m tap_step reads the input at
/// cell * stride + first_offset + m offset_step.
struct AxisTaps {
  int count = 0;
  int first_tap = 0;
  int tap_step = 0;
  int first_offset = 0;
  int offset_step = 0;

  int lowest() const { return offset_step < 0 ? last() : first_offset; }
  int highest() const { return offset_step < 0 ? first_offset : last(); }

 private:
  int last() const { return first_offset + (count - 1) * offset_step; }
};

/// One axis of a convolution, seen as cells: cell i reads the input around i * stride and writes
/// output i * step + phase for each phase in [0, step).
///
///   forward        stride s, step 1: y[i] = sum over k of x[i s + k d - p] w[k]
///   backward data  stride 1, step s: dx[i s + r] = sum of dy[i + (r + p - k d) / s] w[k] over
///                  the k for which s divides r + p - k d
struct ConvolutionAxis {
  int in = 0;
  int out = 0;
  int stride = 1;
  int step = 1;
  int kernel = 1;
  int padding = 0;
  int dilation = 1;
  bool backward = false;

  AxisTaps taps(int phase) const;
  /// Cells that have an output in this phase; phase 0 has most.
  int cells(int phase) const { return (out - phase + step - 1) / step; }
  /// Over all phases; 0 if no phase has taps.
  int lowest_offset() const;
  int highest_offset() const;
};

}  // namespace imslam::nn::kernels
