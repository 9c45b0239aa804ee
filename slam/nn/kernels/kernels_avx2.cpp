#define Eigen Eigen_avx2  // its inline functions must not replace those of other units

#include "slam/nn/kernels/copy_strip.hpp"
#include "slam/nn/kernels/narrow_product.hpp"
#include "slam/nn/kernels/outer_product.hpp"
#include "slam/nn/kernels/pixel_rows.hpp"
#include "slam/nn/kernels/row_product.hpp"
#include "slam/nn/kernels/thin_product.hpp"

namespace imslam::nn::kernels {

const KernelTable* avx2_kernels() {
  static constexpr KernelTable kTable = {
      kLanes,        kMostPackets, copy_strip, row_product,  narrow_product, copy_gradient,
      outer_product, upsample_add, add_relu,   dot_products, unit_rows,      thin_product};
  return &kTable;
}

}  // namespace imslam::nn::kernels
