// GFLOP/s of our convolution beside oneDNN's and PyTorch's, layer by layer, in one run: min and
// median of repeats that take turns, so that other load on the machine meets all. oneDNN's arrays
// lie in its own best formats, PyTorch's in the better of its two, ours in [N, H, W, C]; forward
// uses weights packed before by oneDNN and us, our backward passes pack theirs within the time.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "slam/base/parallel.hpp"
#include "slam/base/random.hpp"
#include "slam/nn/kernels/convolution.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "tools/bench/onednn_convolution.hpp"
#include "tools/bench/pytorch_yardstick.hpp"
#include "tools/bench/taken_times.hpp"

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

struct Measured {
  double best = 0.0, median = 0.0;  ///< [GFLOP/s]
};

/// What is compared on one layer; the yardsticks may be missing.
struct Contestants {
  std::function<void()> ours, onednn;
  PyTorchYardstick* pytorch;
};

struct Results {
  Measured ours, onednn, pytorch;
};

Measured speed_of(const TakenTimes& times, double operations) {
  if (times.empty()) return {};
  return {operations / times.minimum_s(), operations / times.median_s()};
}

Results compare(const Contestants& contestants, double operations, int threads, int rounds) {
  constexpr int kCalls = 5;
  TakenTimes ours(threads), onednn(threads), pytorch(threads);
  for (int round = 0; round < rounds; ++round) {
    measure_round(contestants.ours, kCalls, ours);
    if (contestants.onednn) measure_round(contestants.onednn, kCalls, onednn);
    if (contestants.pytorch == nullptr) continue;
    pytorch.add(contestants.pytorch->times(kCalls));
    let_threads_sleep();
  }
  return {speed_of(ours, operations), speed_of(onednn, operations), speed_of(pytorch, operations)};
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

void print(const Measured& measured, double ours) {
  if (measured.best <= 0.0) return void(std::printf("  %23s", "-"));
  std::printf("  %6.1f (%6.1f)  %5.2f", measured.best, measured.median, ours / measured.best);
}

void measure(
    const Layer& layer, const char* title, PyTorchYardstick& pytorch, int threads, int rounds) {
  constexpr const char* kPasses[] = {"forward", "backward data", "backward weights"};
  const ConvolutionShape shape = shape_of(layer);
  for (const Pass pass : {Pass::kForward, Pass::kBackwardData, Pass::kBackwardWeights}) {
    Arrays arrays(shape);
    if (pytorch.available()) pytorch.prepare_convolution(shape, pass);
    const Results results = compare({arrays.call(pass), onednn_convolution(shape, pass),
                                     pytorch.available() ? &pytorch : nullptr},
                                    giga_operations(shape), threads, rounds);
    std::printf("%-24s %-17s %6.1f (%6.1f)", title, kPasses[static_cast<int>(pass)],
                results.ours.best, results.ours.median);
    print(results.onednn, results.ours.best);
    print(results.pytorch, results.ours.best);
    std::printf("\n");
    std::fflush(stdout);
  }
}

void run(const std::string& wanted, PyTorchYardstick& pytorch, int threads, int rounds) {
  set_thread_count(threads);
  set_onednn_threads(threads);
  if (pytorch.available()) pytorch.set_threads(threads);
  std::printf(
      "\n%s, %d thread(s); GFLOP/s best (median): ours; oneDNN and PyTorch, each with the ratio of "
      "the best\n",
      name(nn::selected_instruction_set()), threads);
  for (const Layer& layer : kLayers) {
    char title[64];
    std::snprintf(title, sizeof title, "%d->%d %dx%d s%d %dx%d", layer.inputs, layer.outputs,
                  layer.kernel, layer.kernel, layer.stride, layer.height, layer.width);
    if (std::string(title).find(wanted) != std::string::npos) {
      measure(layer, title, pytorch, threads, rounds);
    }
  }
}

}  // namespace
}  // namespace imslam::bench

int main(int argc, char** argv) {
  using imslam::nn::InstructionSet;
  CLI::App app("Convolution speed beside oneDNN and PyTorch");
  int set = static_cast<int>(imslam::nn::available_instruction_sets().back());
  std::string layer;
  std::vector<int> threads = {1, 2};
  int rounds = 12;
  std::string python = "/usr/bin/python3";
  app.add_option("--instruction-set", set, "0 SSE2, 1 AVX2, 2 AVX-512");
  app.add_option("--layer", layer, "only layers whose title contains this");
  app.add_option("--threads", threads, "numbers of threads");
  app.add_option("--rounds", rounds, "rounds of five calls");
  app.add_option("--python", python, "the interpreter that has PyTorch; empty: without it");
  CLI11_PARSE(app, argc, argv);
  imslam::nn::select_instruction_set(static_cast<InstructionSet>(set));
  imslam::bench::limit_onednn(static_cast<InstructionSet>(set));
  imslam::bench::PyTorchYardstick pytorch(python);
  if (!pytorch.available()) std::printf("Without PyTorch: %s.\n", pytorch.why_not().c_str());
  for (const int count : threads) imslam::bench::run(layer, pytorch, count, rounds);
  return 0;
}
