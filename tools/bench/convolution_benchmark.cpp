// GFLOP/s of our convolution beside oneDNN's, layer by layer, in one run: min and median of
// repeats that take turns, so that other load on the machine meets both. oneDNN's arrays lie in its
// own best formats, ours in [N, H, W, C]; forward uses weights packed before by both, our backward
// passes pack theirs within the time.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>
#include <thread>
#include <vector>

#include "slam/base/parallel.hpp"
#include "slam/base/random.hpp"
#include "slam/nn/kernels/convolution.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "tools/bench/onednn_convolution.hpp"

namespace imslam::bench {
namespace {

using nn::ConvolutionShape;

struct Layer {
  int inputs, outputs, kernel, stride, height, width;
};

constexpr Layer kLayers[] = {
    {1, 16, 3, 1, 192, 640}, {16, 16, 3, 1, 192, 640}, {16, 32, 3, 2, 192, 640},
    {32, 32, 3, 1, 96, 320}, {32, 64, 3, 2, 96, 320},  {64, 64, 3, 1, 48, 160},
    {64, 96, 3, 2, 48, 160}, {96, 96, 3, 1, 24, 80},   {128, 128, 3, 1, 48, 160},
    {64, 64, 1, 1, 48, 160}, {128, 64, 1, 1, 48, 160}, {64, 2, 3, 1, 48, 160},
    {3, 16, 3, 2, 192, 640}, {81, 64, 3, 1, 24, 80},
};

ConvolutionShape shape_of(const Layer& layer) {
  ConvolutionShape shape;
  shape.in_height = layer.height;
  shape.in_width = layer.width;
  shape.in_channels = layer.inputs;
  shape.out_channels = layer.outputs;
  shape.kernel_height = shape.kernel_width = layer.kernel;
  shape.stride_y = shape.stride_x = layer.stride;
  shape.padding_y = shape.padding_x = layer.kernel / 2;
  return shape;
}

double giga_operations(const ConvolutionShape& shape) {
  return 2e-9 * double(shape.output_size()) * double(shape.weight_size()) / shape.out_channels;
}

/// [s] Of one thread its own processor time, so that time lent to other programs does not count; of
/// several threads wall time.
double now(int threads) {
  timespec time{};
  clock_gettime(threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

/// Seconds of each repeat.
class Times {
 public:
  explicit Times(int threads) : threads_(threads) {}
  void measure(const std::function<void()>& call) {
    const double start = now(threads_);
    call();
    seconds_.push_back(now(threads_) - start);
  }
  double minimum() const { return *std::min_element(seconds_.begin(), seconds_.end()); }
  double median() const {
    std::vector<double> sorted = seconds_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }

 private:
  int threads_;
  std::vector<double> seconds_;
};

struct Measured {
  double best = 0.0, median = 0.0;  ///< [GFLOP/s]
};

/// oneDNN's OpenMP threads go on spinning after a call; ours wait until they have given up.
void measure_round(const std::function<void()>& call, int calls, Times& times) {
  call();
  for (int i = 0; i < calls; ++i) times.measure(call);
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

std::pair<Measured, Measured> compare(const std::function<void()>& ours,
                                      const std::function<void()>& yardstick,
                                      double operations,
                                      int threads,
                                      int rounds) {
  constexpr int kCalls = 5;
  Times our_times(threads), yardstick_times(threads);
  for (int round = 0; round < rounds; ++round) {
    measure_round(ours, kCalls, our_times);
    if (yardstick) measure_round(yardstick, kCalls, yardstick_times);
  }
  const auto speed = [operations](const Times& times) -> Measured {
    return {operations / times.minimum(), operations / times.median()};
  };
  return {speed(our_times), yardstick ? speed(yardstick_times) : Measured{}};
}

/// Arrays of one layer and the calls that work on them.
struct Arrays {
  explicit Arrays(const ConvolutionShape& s)
      : shape(s),
        x(normal(s.input_size())),
        w(normal(s.weight_size())),
        b(normal(static_cast<std::size_t>(s.out_channels))),
        y(normal(s.output_size())),
        packed(s, w.data(), b.data()) {}

  std::function<void()> call(Pass pass) {
    if (pass == Pass::kForward) {
      return [this] {
        convolution_forward(shape, x.data(), packed, nn::Activation::kNone, y.data(), &workspace);
      };
    }
    if (pass == Pass::kBackwardData) {
      return [this] { convolution_backward_data(shape, w.data(), y.data(), x.data(), &workspace); };
    }
    return [this] {
      convolution_backward_weights(shape, x.data(), y.data(), w.data(), b.data(), &workspace);
    };
  }

  static std::vector<float> normal(std::size_t count) {
    Random random(1);
    std::vector<float> values(count);
    for (float& value : values) value = static_cast<float>(random.uniform(-1.0, 1.0));
    return values;
  }

  ConvolutionShape shape;
  std::vector<float> x, w, b, y;
  nn::PackedWeights packed;
  nn::Workspace workspace;
};

void run(const std::string& wanted, int threads, int rounds) {
  set_thread_count(threads);
  set_onednn_threads(threads);
  std::printf("\n%s, %d thread(s); GFLOP/s best (median): ours, oneDNN, ratio of the best\n",
              name(nn::selected_instruction_set()), threads);
  constexpr const char* kPasses[] = {"forward", "backward data", "backward weights"};
  for (const Layer& layer : kLayers) {
    const ConvolutionShape shape = shape_of(layer);
    char title[64];
    std::snprintf(title, sizeof title, "%d->%d %dx%d s%d %dx%d", layer.inputs, layer.outputs,
                  layer.kernel, layer.kernel, layer.stride, layer.height, layer.width);
    if (std::string(title).find(wanted) == std::string::npos) continue;
    for (const Pass pass : {Pass::kForward, Pass::kBackwardData, Pass::kBackwardWeights}) {
      Arrays arrays(shape);
      const auto [ours, yardstick] = compare(arrays.call(pass), onednn_convolution(shape, pass),
                                             giga_operations(shape), threads, rounds);
      std::printf("%-24s %-17s %6.1f (%6.1f)  %6.1f (%6.1f)  %5.2f\n", title,
                  kPasses[static_cast<int>(pass)], ours.best, ours.median, yardstick.best,
                  yardstick.median, yardstick.best > 0 ? ours.best / yardstick.best : 0.0);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace imslam::bench

int main(int argc, char** argv) {
  using imslam::nn::InstructionSet;
  CLI::App app("Convolution speed beside oneDNN");
  int set = static_cast<int>(imslam::nn::available_instruction_sets().back());
  std::string layer;
  std::vector<int> threads = {1, 2};
  int rounds = 12;
  app.add_option("--instruction-set", set, "0 SSE2, 1 AVX2, 2 AVX-512");
  app.add_option("--layer", layer, "only layers whose title contains this");
  app.add_option("--threads", threads, "numbers of threads");
  app.add_option("--rounds", rounds, "rounds of five calls");
  CLI11_PARSE(app, argc, argv);
  imslam::nn::select_instruction_set(static_cast<InstructionSet>(set));
  imslam::bench::limit_onednn(static_cast<InstructionSet>(set));
  for (const int count : threads) imslam::bench::run(layer, count, rounds);
  return 0;
}
