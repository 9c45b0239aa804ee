// How long the matching network takes, part by part: one encoded image, a stereo pair side by side,
// flow and disparity of many points. Weights and images are random: the time does not depend on
// them.
//
//   network_benchmark [--width 752] [--height 480] [--points 600] [--repeats 40] [--threads 0]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

#include "slam/base/parallel.hpp"
#include "slam/base/random.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "tools/bench/taken_times.hpp"
#include "vo_net/match_inference.hpp"

namespace imslam {
namespace {

struct Request {
  int width = 752;
  int height = 480;
  int points = 600;
  int repeats = 40;
  int threads = 0;
};

GrayImage random_image(const Request& request, Random& random) {
  GrayImage image;
  image.width = request.width;
  image.height = request.height;
  image.pixels.resize(static_cast<std::size_t>(request.width) *
                      static_cast<std::size_t>(request.height));
  for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(random.integer(0, 255));
  return image;
}

/// What `prepare` does is not counted.
void measure(const char* what,
             int repeats,
             const std::function<void()>& prepare,
             const std::function<void()>& work) {
  prepare();
  work();  // the first one allocates
  bench::TakenTimes times(thread_count());
  for (int i = 0; i < repeats; ++i) {
    prepare();
    times.measure(work);
  }
  fmt::print("{:<24}{:>10.2f}{:>10.2f}\n", what, 1e3 * times.minimum_s(), 1e3 * times.median_s());
}

void run(const Request& request) {
  if (request.threads > 0) set_thread_count(request.threads);
  Random random(1);
  const auto network = std::make_shared<vo::MatchNetwork<float>>(vo::MatchNetworkOptions(), random);
  network->fold();
  vo::MatchInference inference(network);
  const GrayImage left = random_image(request, random);
  const GrayImage right = random_image(request, random);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < request.points; ++i) {
    points.push_back(
        {random.uniform(0.0, request.width - 1.0), random.uniform(0.0, request.height - 1.0)});
  }
  fmt::print("{} x {}, {} points, {}, {} threads\n{:<24}{:>10}{:>10}\n", request.width,
             request.height, request.points, nn::name(nn::selected_instruction_set()),
             thread_count(), "[ms]", "min", "median");
  const auto nothing = [] {};
  const auto advance = [&] { inference.advance(left, right, 1); };
  const auto flow = [&] { inference.flow(points, {0.0, 0.0}); };
  const auto stereo = [&] { inference.stereo(points); };
  nn::Tape<float> tape(nn::Mode::kInference);
  measure("encode one image", request.repeats, nothing, [&] {
    tape.reset();
    const nn::Var image = tape.make({1, request.height, request.width, 1});
    std::copy(left.pixels.begin(), left.pixels.end(), tape.data(image));
    network->encode(tape, image);
  });
  advance();
  measure("encode a pair", request.repeats, nothing, advance);
  measure("flow", request.repeats, advance, flow);
  measure("stereo", request.repeats, advance, stereo);
  measure("frame: all of it", request.repeats, nothing, [&] {
    advance();
    flow();
    stereo();
  });
}

}  // namespace
}  // namespace imslam

int main(int argc, char** argv) {
  imslam::Request request;
  CLI::App app("Times of the matching network");
  app.add_option("--width", request.width)->capture_default_str();
  app.add_option("--height", request.height)->capture_default_str();
  app.add_option("--points", request.points)->capture_default_str();
  app.add_option("--repeats", request.repeats)->capture_default_str();
  app.add_option("--threads", request.threads, "0: all cores")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  imslam::run(request);
  return 0;
}
