#include "slam/plugins/routing/allocation_surrogate.hpp"

#include "slam/nn/ops/activation.hpp"
#include "slam/plugins/routing/surrogate_features.hpp"

namespace imslam::routing {
namespace {

constexpr int kHidden = 32;
constexpr double kFirstSum = 2.0;  ///< the constant baseline that the paper's yardstick has

}  // namespace

using learner::Matrix;
using learner::Vector;

template <typename S>
SurrogateNetwork<S>::SurrogateNetwork(Random& random)
    : pair_in(kPairFeatures, kHidden, random),
      pair_out(kHidden, 1, random),
      whole_in(kWholeFeatures, kHidden, random),
      whole_out(kHidden, 1, random) {
  nn::initialise_constant(pair_out.weight, 0.0);
  nn::initialise_constant(whole_out.weight, 0.0);
  nn::initialise_constant(whole_out.bias, kFirstSum);
}

template <typename S>
typename SurrogateNetwork<S>::Answer SurrogateNetwork<S>::forward(nn::Tape<S>& tape,
                                                                  nn::Var pairs,
                                                                  nn::Var whole) const {
  const nn::Var pair = nn::tanh(tape, pair_in.forward(tape, pairs));
  const nn::Var all = nn::tanh(tape, whole_in.forward(tape, whole));
  return {pair_out.forward(tape, pair), whole_out.forward(tape, all)};
}

template <typename S>
void SurrogateNetwork<S>::collect(nn::ParameterList<S>& list) {
  pair_in.collect(list, "pair_in.");
  pair_out.collect(list, "pair_out.");
  whole_in.collect(list, "whole_in.");
  whole_out.collect(list, "whole_out.");
}

void AllocationSurrogate::look_at(const AllocationProblem& problem, const Vector& z) {
  tape_.reset();
  probabilities_ = allocation_probabilities(z, problem.agents());
  const SurrogateFeatures seen = surrogate_features(problem.instance(), probabilities_);
  answer_ = network_.forward(tape_, tape_.constant(seen.pairs), tape_.constant(seen.whole));
  prices_.resize(probabilities_.rows(), probabilities_.cols());
  const float* const prices = tape_.data(answer_.prices);
  for (Eigen::Index i = 0; i < prices_.rows(); ++i) {
    for (Eigen::Index j = 0; j < prices_.cols(); ++j)
      prices_(i, j) = prices[i * prices_.cols() + j];
  }
  sum_ = tape_.data(answer_.sum)[0];
  dprices_ = Matrix::Zero(prices_.rows(), prices_.cols());
  dsum_ = 0.0;
}

double AllocationSurrogate::value(const Vector& x, const Vector&) const {
  double value = sum_;
  for (Eigen::Index i = 0; i < x.size(); ++i) value += prices_(i, static_cast<Eigen::Index>(x[i]));
  return value;
}

Vector AllocationSurrogate::mean_slope(const Vector&, const Vector&) const {
  const Vector mean = (probabilities_.array() * prices_.array()).rowwise().sum();
  const Matrix slope =
      (probabilities_.array() * (prices_.array().colwise() - mean.array())).matrix().transpose();
  return Eigen::Map<const Vector>(slope.data(), slope.size());
}

void AllocationSurrogate::accumulate(const Vector& x,
                                     const Vector&,
                                     double dvalue,
                                     const Vector& dslope) {
  dsum_ += dvalue;
  for (Eigen::Index i = 0; i < x.size(); ++i)
    dprices_(i, static_cast<Eigen::Index>(x[i])) += dvalue;
  const Matrix d =
      Eigen::Map<const Matrix>(dslope.data(), prices_.cols(), prices_.rows()).transpose();
  const Vector mean = (probabilities_.array() * d.array()).rowwise().sum();
  dprices_.array() += probabilities_.array() * (d.array().colwise() - mean.array());
}

void AllocationSurrogate::add_gradients_to(const nn::ParameterList<float>& parameters,
                                           nn::Gradients<float>& sums) {
  nn::Tensor<float> seed({dprices_.size(), 1});
  for (Eigen::Index i = 0; i < dprices_.rows(); ++i) {
    for (Eigen::Index j = 0; j < dprices_.cols(); ++j) {
      seed[i * dprices_.cols() + j] = static_cast<float>(dprices_(i, j));
    }
  }
  tape_.backward(answer_.prices, seed);
  nn::Tensor<float> sum_seed({1, 1});
  sum_seed[0] = static_cast<float>(dsum_);
  tape_.backward(answer_.sum, sum_seed);
  tape_.add_gradients_to(parameters, sums);
}

template struct SurrogateNetwork<float>;

}  // namespace imslam::routing
