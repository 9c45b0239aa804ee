// Milliseconds to render a 752x480 stereo pair with depth and flow, whole and by stage.
//
//   simulation_benchmark [SCENE...]
//
// Medians over 1.5 s of motion. CPU time (of all threads) hardly depends on what else runs on the
// machine; wall time does.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "datasets/simulation/euroc_writer.hpp"
#include "datasets/simulation/image_sensor.hpp"
#include "datasets/simulation/simulator.hpp"
#include "datasets/simulation/truth.hpp"
#include "datasets/simulation/view.hpp"

namespace imslam::simulation {
namespace {

double wall_ms() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

struct Times {
  std::vector<double> wall_ms;
  std::vector<double> cpu_ms;
};

class StopWatch {
 public:
  void measure(const std::string& stage, const std::function<void()>& work) {
    const double wall = wall_ms();
    const double cpu = cpu_ms();
    work();
    times_[stage].wall_ms.push_back(wall_ms() - wall);
    times_[stage].cpu_ms.push_back(cpu_ms() - cpu);
    if (times_[stage].wall_ms.size() == 1) order_.push_back(stage);
  }

  void print(const std::string& scene) const {
    for (const std::string& stage : order_) {
      const Times& times = times_.at(stage);
      const double least = *std::min_element(times.wall_ms.begin(), times.wall_ms.end());
      fmt::print("{:10} {:24} cpu {:7.1f}   wall {:7.1f}   least wall {:7.1f}\n", scene, stage,
                 median(times.cpu_ms), median(times.wall_ms), least);
    }
  }

 private:
  std::map<std::string, Times> times_;
  std::vector<std::string> order_;
};

SimulationOptions options_of(const std::string& scene) {
  SimulationOptions options = default_sequence_options();
  options.scene = scene;
  options.seed = 11;
  options.duration_s = 1.5;
  options.rest_s = 0.0;
  return options;
}

/// The stages of one image, as Simulator puts them together.
void measure_stages(const SimulationOptions& options,
                    const Simulator& simulator,
                    StopWatch& watch) {
  TextureBank bank(options.textures);
  const Random random(static_cast<std::uint64_t>(options.seed));
  World world(make_scene(options, bank, random.fork(1)), random.fork(3));
  const StereoRig& rig = simulator.rig();
  const RayTable rays(rig.left);
  const ImageSensor sensor(options.image, rig.left);
  View view;
  for (std::size_t i = 0; i < simulator.frame_count(); ++i) {
    const double time_s = simulator.frame_time_s(i);
    const auto camera = [&](double at_s) {
      return camera_motion(simulator.motion().at(at_s), rig.T_body_left);
    };
    const CameraMotion now = camera(time_s);
    watch.measure("  one image: move things", [&] { world.set_time(time_s); });
    const auto render = [&](bool antialias) {
      render_view(world, rays, now.T_world_camera, antialias, view);
    };
    watch.measure("  one image: a ray a pixel", [&] { render(false); });
    watch.measure("  one image: all rays", [&] { render(true); });
    std::vector<float> radiance;
    watch.measure("  one image: motion blur", [&] {
      radiance = blur_motion(view, world, rays, now, time_s, 1e-3 * options.image.exposure_ms);
    });
    watch.measure("  one image: sensor", [&] { sensor.expose(radiance, 0.5, i); });
    watch.measure("  truth: depth", [&] { depth_of(view, rays); });
    const double next_s = simulator.frame_time_s(i + 1);
    watch.measure("  truth: flow", [&] {
      flow_of(view, world, rays, rig.left, now.T_world_camera, camera(next_s).T_world_camera,
              time_s, next_s);
    });
  }
}

void measure_scene(const std::string& scene) {
  const SimulationOptions options = options_of(scene);
  Simulator simulator(options);
  StopWatch watch;
  for (std::size_t i = 0; i < simulator.frame_count(); ++i) {
    const FrameRequest request{true, simulator.frame_time_s(i + 1)};
    SimulatedFrame frame;
    watch.measure("pair with truth",
                  [&] { frame = simulator.render(simulator.frame_time_s(i), request); });
    watch.measure("encode depth", [&] { encode_depth(frame); });
    watch.measure("encode flow", [&] { encode_flow(frame); });
  }
  measure_stages(options, simulator, watch);
  watch.print(scene);
}

}  // namespace
}  // namespace imslam::simulation

int main(int count, char** arguments) {
  std::vector<std::string> scenes(arguments + 1, arguments + count);
  if (scenes.empty()) scenes = {"room", "corridor", "street", "forest"};
  for (const std::string& scene : scenes) imslam::simulation::measure_scene(scene);
}
