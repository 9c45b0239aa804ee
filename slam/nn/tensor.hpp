#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/nn/arena.hpp"
#include "slam/nn/scalar.hpp"
#include "slam/nn/shape.hpp"

namespace imslam::nn {

template <typename S>
using RowMatrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
template <typename S>
using MatrixMap = Eigen::Map<RowMatrix<S>, Eigen::Aligned64>;
template <typename S>
using ConstMatrixMap = Eigen::Map<const RowMatrix<S>, Eigen::Aligned64>;
template <typename S>
using ArrayMap = Eigen::Map<Eigen::Array<S, Eigen::Dynamic, 1>, Eigen::Aligned64>;
template <typename S>
using ConstArrayMap = Eigen::Map<const Eigen::Array<S, Eigen::Dynamic, 1>, Eigen::Aligned64>;

/// Numbers of one shape on 64-byte aligned storage. Copies share the storage (a handle); clone()
/// makes an independent one.
///
///   Tensor<float> x({2, 3});    // zeros
///   x.matrix()                  // rows() x channels(), row-major
template <typename S>
class Tensor {
 public:
  Tensor() : Tensor(Shape{0}) {}
  explicit Tensor(const Shape& shape)
      : shape_(shape),
        storage_(static_cast<S*>(::operator new(bytes_of(shape), kAlign)),
                 [](S* memory) { ::operator delete(memory, kAlign); }) {
    std::uninitialized_fill_n(storage_.get(), shape.size(), S(0));
  }
  Tensor(const Shape& shape, std::initializer_list<S> values) : Tensor(shape) {
    expects(static_cast<Index>(values.size()) == shape.size(),
            "Tensor: as many values as the shape");
    std::copy(values.begin(), values.end(), data());
  }

  const Shape& shape() const { return shape_; }
  Index size() const { return shape_.size(); }
  S* data() { return storage_.get(); }
  const S* data() const { return storage_.get(); }
  S& operator[](Index i) { return storage_.get()[i]; }
  const S& operator[](Index i) const { return storage_.get()[i]; }

  MatrixMap<S> matrix() { return {data(), shape_.rows(), shape_.channels()}; }
  ConstMatrixMap<S> matrix() const { return {data(), shape_.rows(), shape_.channels()}; }
  ArrayMap<S> array() { return {data(), size()}; }
  ConstArrayMap<S> array() const { return {data(), size()}; }

  Tensor clone() const {
    Tensor copy(shape_);
    std::copy_n(data(), size(), copy.data());
    return copy;
  }

 private:
  static constexpr std::align_val_t kAlign{Arena::kAlignment};
  static std::size_t bytes_of(const Shape& shape) {
    return static_cast<std::size_t>(std::max<Index>(shape.size(), 1)) * sizeof(S);
  }

  Shape shape_;
  std::shared_ptr<S> storage_;
};

/// A tensor of another scalar with the same numbers; tangents of Dual are dropped or zero.
template <typename To, typename From>
Tensor<To> cast(const Tensor<From>& from) {
  Tensor<To> to(from.shape());
  for (Index i = 0; i < from.size(); ++i) to[i] = To(value_of(from[i]));
  return to;
}

template <typename S>
struct NamedTensor {
  std::string name;
  Tensor<S> tensor;
};

}  // namespace imslam::nn
