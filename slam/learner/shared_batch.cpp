#include "slam/learner/shared_batch.hpp"

#include <algorithm>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "slam/base/error.hpp"

namespace imslam::learner {
namespace {

/// All gradients in one row, then the loss.
std::vector<float> row_of(const nn::Gradients<float>& gradients, double loss) {
  std::vector<float> row;
  for (const nn::Tensor<float>& gradient : gradients) {
    row.insert(row.end(), gradient.data(), gradient.data() + gradient.size());
  }
  row.push_back(static_cast<float>(loss));
  return row;
}

std::size_t row_length(const nn::Gradients<float>& gradients) {
  std::size_t length = 1;
  for (const nn::Tensor<float>& gradient : gradients) {
    length += static_cast<std::size_t>(gradient.size());
  }
  return length;
}

/// The mean; returns that of the losses.
double take_mean(const std::vector<float>& sum, float parts, nn::Gradients<float>& gradients) {
  auto from = sum.begin();
  for (nn::Tensor<float>& gradient : gradients) {
    std::transform(from, from + gradient.size(), gradient.data(),
                   [parts](float value) { return value / parts; });
    from += gradient.size();
  }
  return static_cast<double>(*from / parts);
}

}  // namespace

double shared_batch(ProcessGroup& group,
                    nn::DataParallel<float>& batch,
                    std::size_t samples,
                    std::size_t parts,
                    const nn::DataParallel<float>::SampleLoss& loss,
                    nn::Gradients<float>& gradients) {
  expects(parts > 0 && samples % parts == 0, "shared_batch: parts of equal size");
  const std::size_t size = samples / parts;
  const auto sum = ordered_sum(group, parts, row_length(gradients), [&](std::size_t part) {
    const double mean = batch.run(
        size, [&](nn::Tape<float>& tape, std::size_t i) { return loss(tape, part * size + i); },
        gradients);
    return row_of(gradients, mean);
  });
  return take_mean(sum, static_cast<float>(parts), gradients);
}

BatchTally shared_tally(ProcessGroup& group, const BatchTally& own) {
  static_assert(std::is_trivially_copyable_v<BatchTally>);
  std::string bytes(sizeof(BatchTally), '\0');
  std::memcpy(bytes.data(), &own, sizeof(own));
  BatchTally all;
  for (const std::string& one : group.gather(bytes)) {
    BatchTally tally;
    std::memcpy(&tally, one.data(), sizeof(tally));
    all.residual = std::max(all.residual, tally.residual);
    for (std::size_t i = 0; i < all.refused.size(); ++i) all.refused[i] += tally.refused[i];
  }
  std::memcpy(bytes.data(), &all, sizeof(all));
  const std::string agreed = group.broadcast(bytes);
  std::memcpy(&all, agreed.data(), sizeof(all));
  return all;
}

}  // namespace imslam::learner
