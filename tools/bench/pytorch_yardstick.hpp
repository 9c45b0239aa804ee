#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "tools/bench/onednn_convolution.hpp"

namespace imslam::bench {

/// pytorch_yardstick.py in a process of its own, which takes turns with ours. PyTorch (Debian:
/// python3-torch) is a yardstick: without it available() is false and `why_not` says so.
class PyTorchYardstick {
 public:
  /// `python`: the interpreter that has PyTorch; empty: none is wanted.
  explicit PyTorchYardstick(const std::string& python);
  ~PyTorchYardstick();
  PyTorchYardstick(const PyTorchYardstick&) = delete;
  PyTorchYardstick& operator=(const PyTorchYardstick&) = delete;

  bool available() const { return process_ > 0; }
  const std::string& why_not() const { return why_not_; }

  void set_threads(int threads);
  /// What the next times() are of.
  void prepare_convolution(const nn::ConvolutionShape& shape, Pass pass);
  /// The encoder of a file of weights on [images, height, width, 2]; checksums of its four outputs
  /// without the backward pass, see the script.
  std::vector<double> prepare_encoder(
      const std::string& weights, int images, int height, int width, bool backward);
  /// [s] of each call, after one that is not counted.
  std::vector<double> times(int calls);

 private:
  std::string start(const std::string& python);  ///< why it did not start, or nothing
  void stop();
  std::vector<double> ask(const std::string& request);

  int process_ = 0;
  std::FILE* requests_ = nullptr;
  std::FILE* answers_ = nullptr;
  std::string why_not_;
};

}  // namespace imslam::bench
