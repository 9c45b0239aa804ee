#include "slam/learner/replay_buffer.hpp"

#include <algorithm>

#include "slam/base/error.hpp"

namespace imslam::learner {

ReplayBuffer::ReplayBuffer(std::size_t capacity, std::uint64_t seed)
    : capacity_(capacity), random_(seed) {
  expects(capacity >= 1, "ReplayBuffer: room for one item at least");
}

void ReplayBuffer::write(const Vector& item) {
  expects(items_.empty() || item.size() == items_.front().size(),
          "ReplayBuffer::write: items of one length");
  const std::uint64_t number = written_++;
  if (items_.size() < capacity_) {
    items_.push_back(item);
    return;
  }
  const std::int64_t place = random_.fork(number).integer(0, static_cast<std::int64_t>(number));
  if (place < static_cast<std::int64_t>(capacity_)) items_[static_cast<std::size_t>(place)] = item;
}

std::vector<Vector> ReplayBuffer::read(const Replay& query) const {
  std::vector<Vector> drawn;
  if (items_.empty()) return drawn;
  Random random = query.random;
  for (std::size_t i = 0; i < query.count; ++i) {
    const std::int64_t place = random.integer(0, static_cast<std::int64_t>(items_.size()) - 1);
    drawn.push_back(items_[static_cast<std::size_t>(place)]);
  }
  return drawn;
}

void ReplayBuffer::save(nn::WeightsWriter& writer, const std::string& prefix) const {
  writer.add(prefix + "written", static_cast<std::int64_t>(written_));
  if (items_.empty()) return;
  const Eigen::Index length = items_.front().size();
  nn::Tensor<double> all({static_cast<nn::Index>(items_.size()), length});
  for (std::size_t i = 0; i < items_.size(); ++i) {
    std::copy_n(items_[i].data(), length, all.data() + static_cast<Eigen::Index>(i) * length);
  }
  writer.add(prefix + "items", all);
}

void ReplayBuffer::restore(const nn::WeightsFile& file, const std::string& prefix) {
  written_ = static_cast<std::uint64_t>(file.integer(prefix + "written"));
  items_.clear();
  if (written_ == 0) return;
  const nn::TensorEntry* const entry = file.find(prefix + "items");
  const auto count = static_cast<nn::Index>(std::min<std::uint64_t>(written_, capacity_));
  if (entry == nullptr || entry->shape.rank() != 2 || entry->shape.rows() != count) {
    throw InputError(file.name() + ": " + prefix + "items: expected " + std::to_string(count) +
                         " items; was the capacity another one?",
                     ExitCode::kModel);
  }
  nn::Tensor<double> all(entry->shape);
  file.read_into(prefix + "items", all);
  const Eigen::Index length = entry->shape.channels();
  for (nn::Index i = 0; i < count; ++i) {
    items_.push_back(Eigen::Map<const Vector>(all.data() + i * length, length));
  }
}

}  // namespace imslam::learner
