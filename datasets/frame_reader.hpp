#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "datasets/sequence.hpp"

namespace imslam::datasets {

/// Reads the frames [first, last) of a sequence in order, decoding ahead on a second thread.
class FrameReader {
 public:
  FrameReader(Sequence& sequence, std::size_t first, std::size_t last, std::size_t ahead = 4);
  ~FrameReader();
  FrameReader(const FrameReader&) = delete;
  FrameReader& operator=(const FrameReader&) = delete;

  /// The next frame; empty after the last one. Rethrows what the decoding thread threw.
  std::optional<StereoFrame> next();

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace imslam::datasets
