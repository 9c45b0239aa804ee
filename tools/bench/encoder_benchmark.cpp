// The matching network's encoder, ours beside the same in PyTorch, in one run with turns taken:
// forward alone as the odometry runs it, forward and backward as the training does. The same
// weights and the same images; the outputs of both must agree.
//
//   encoder_benchmark [--width 752] [--height 480] [--images 2] [--threads 1 2] [--rounds 8]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "slam/base/parallel.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/reduce.hpp"
#include "tools/bench/pytorch_yardstick.hpp"
#include "tools/bench/taken_times.hpp"
#include "vo_net/match_weights.hpp"

namespace imslam::bench {
namespace {

using nn::Index;
using nn::Var;

struct Request {
  int width = 752;
  int height = 480;
  int images = 2;
  int rounds = 8;
  std::vector<int> threads = {1, 2};
  std::string weights = "vo_net/weights/match_network.safetensors";
  std::string python = "/usr/bin/python3";
};

class OurEncoder {
 public:
  explicit OurEncoder(const Request& request)
      : images_({request.images, request.height, request.width, 2}),
        network_(vo::load_match_network(request.weights).network) {
    for (Index i = 0; i < images_.size(); ++i) {
      images_.data()[i] = static_cast<float>(i * 31 % 97) / 48.0F - 1.0F;
    }
  }

  vo::FeaturePyramid forward() {
    inference_.reset();
    return network_->encoder.forward(inference_, inference_.constant(images_));
  }

  void forward_and_backward() {
    training_.reset();
    const vo::FeaturePyramid f = network_->encoder.forward(training_, training_.constant(images_));
    Var loss = sum(training_, f.half);
    for (const Var level : {f.quarter, f.eighth, f.sixteenth}) {
      loss = add(training_, loss, sum(training_, level));
    }
    training_.backward(loss);
  }

  std::vector<double> checksums() {
    const vo::FeaturePyramid f = forward();
    std::vector<double> sums;
    for (const Var level : {f.half, f.quarter, f.eighth, f.sixteenth}) {
      double sum = 0.0;
      for (Index i = 0; i < inference_.shape(level).size(); ++i) {
        sum += static_cast<double>(inference_.data(level)[i]) * static_cast<double>(i % 13 - 6);
      }
      sums.push_back(sum);
    }
    return sums;
  }

 private:
  nn::Tensor<float> images_;
  std::shared_ptr<vo::MatchNetwork<float>> network_;
  nn::Tape<float> inference_{nn::Mode::kInference};
  nn::Tape<float> training_;
};

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

void compare(const Request& request, OurEncoder& ours, PyTorchYardstick& pytorch, int threads) {
  constexpr int kCalls = 3;
  set_thread_count(threads);
  if (pytorch.available()) pytorch.set_threads(threads);
  for (const bool backward : {false, true}) {
    const auto call = [&] {
      if (backward) return ours.forward_and_backward();
      ours.forward();
    };
    if (pytorch.available()) {
      pytorch.prepare_encoder(request.weights, request.images, request.height, request.width,
                              backward);
    }
    TakenTimes our_times(threads), pytorch_times(threads);
    for (int round = 0; round < request.rounds; ++round) {
      measure_round(call, kCalls, our_times);
      if (!pytorch.available()) continue;
      pytorch_times.add(pytorch.times(kCalls));
      let_threads_sleep();
    }
    fmt::print("{:<8}{:<22}{:>8.1f} ({:>6.1f})", threads,
               backward ? "forward and backward" : "forward", 1e3 * our_times.minimum_s(),
               1e3 * our_times.median_s());
    if (!pytorch_times.empty()) {
      fmt::print("{:>8.1f} ({:>6.1f}){:>8.2f}", 1e3 * pytorch_times.minimum_s(),
                 1e3 * pytorch_times.median_s(), pytorch_times.minimum_s() / our_times.minimum_s());
    }
    fmt::print("\n");
  }
}

void run(const Request& request) {
  OurEncoder ours(request);
  PyTorchYardstick pytorch(request.python);
  fmt::print("Encoder on {} x {} x {}, {}\n", request.images, request.height, request.width,
             nn::name(nn::selected_instruction_set()));
  if (pytorch.available()) {
    const std::vector<double> theirs = pytorch.prepare_encoder(
        request.weights, request.images, request.height, request.width, false);
    fmt::print("largest difference of the outputs' checksums from PyTorch's: {:.2g}\n",
               largest_difference(ours.checksums(), theirs));
  } else {
    fmt::print("Without PyTorch: {}.\n", pytorch.why_not());
  }
  fmt::print("threads, pass; ms best (median): ours, PyTorch, how many times faster ours is\n");
  for (const int threads : request.threads) compare(request, ours, pytorch, threads);
}

}  // namespace
}  // namespace imslam::bench

int main(int argc, char** argv) {
  imslam::bench::Request request;
  CLI::App app("The matching network's encoder beside PyTorch");
  app.add_option("--width", request.width)->capture_default_str();
  app.add_option("--height", request.height)->capture_default_str();
  app.add_option("--images", request.images)->capture_default_str();
  app.add_option("--rounds", request.rounds, "rounds of three calls")->capture_default_str();
  app.add_option("--threads", request.threads)->capture_default_str();
  app.add_option("--weights", request.weights)->capture_default_str();
  app.add_option("--python", request.python, "the interpreter that has PyTorch; empty: without it")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  imslam::bench::run(request);
  return 0;
}
