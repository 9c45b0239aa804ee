#include "datasets/simulation/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>
#include <vector>

#include "datasets/simulation/euroc_writer.hpp"
#include "datasets/simulation/simulator.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/file.hpp"

namespace imslam::simulation {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr const char* kRecipe = "simulation.yaml";
constexpr std::size_t kBatch = 8;  ///< frames in memory at once

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Only what an earlier simulation wrote is ever removed.
void prepare_folder(const fs::path& out, bool force) {
  std::error_code error;
  if (!fs::exists(out, error) || (fs::is_directory(out, error) && fs::is_empty(out, error))) return;
  if (!fs::is_directory(out, error)) {
    throw InputError(out.string() + ": is a file; give a folder", ExitCode::kOutput);
  }
  if (!force) {
    throw InputError(out.string() + ": is not empty; give another folder or simulation.force=true",
                     ExitCode::kOutput);
  }
  if (!fs::exists(out / kRecipe, error)) {
    throw InputError(out.string() + ": holds no earlier simulation; nothing else is replaced",
                     ExitCode::kOutput);
  }
  fs::remove_all(out / "mav0", error);
  if (error) throw InputError(out.string() + ": " + error.message(), ExitCode::kOutput);
}

void write_options(const fs::path& out, const Simulator& simulator) {
  SimulationOptions options = simulator.options();
  options.force = false;
  Config config;
  config.section("simulation", options);
  write_file_atomic(out / kRecipe,
                    "# Textures: " + simulator.texture_bank() + "\n" + config.to_yaml());
}

double write_imu(const Simulator& simulator, EurocWriter& writer) {
  double distance = 0.0;
  Eigen::Vector3d last = simulator.motion().at(0.0).T_world_body.translation();
  ImuModel imu = simulator.imu();
  for (std::size_t i = 0; i < simulator.imu_count(); ++i) {
    const SimulatedImuSample sample = imu.next();
    writer.add_imu(sample);
    const Eigen::Vector3d& position = sample.truth.T_world_body.translation();
    distance += (position - last).norm();
    last = position;
  }
  return distance;
}

/// Images that get lost on the way, as on real recordings.
void drop_images(const SimulationOptions& options, std::size_t index, SimulatedFrame& frame) {
  Random chance = Random(static_cast<std::uint64_t>(options.seed)).fork(0xD209).fork(index);
  if (chance.chance(0.01 * options.drop_left_percent)) frame.left = GrayImage();
  if (chance.chance(0.01 * options.drop_right_percent)) frame.right = GrayImage();
}

}  // namespace

SimulationSummary simulate(const SimulationOptions& options,
                           const fs::path& out,
                           const SimulationProgress& progress) {
  options.validate();
  prepare_folder(out, options.force);
  Simulator simulator(options);
  EurocWriter writer(out, simulator);
  write_options(out, simulator);

  SimulationSummary summary;
  summary.frames = simulator.frame_count();
  summary.imu_samples = simulator.imu_count();
  summary.textures = simulator.texture_bank();
  summary.distance_m = write_imu(simulator, writer);
  std::vector<SimulatedFrame> batch;
  for (std::size_t i = 0; i < summary.frames; ++i) {
    const auto start = Clock::now();
    FrameRequest request;
    request.depth = options.truth_depth;
    if (options.truth_flow) request.flow_to_s = simulator.frame_time_s(i + 1);
    batch.push_back(simulator.render(simulator.frame_time_s(i), request));
    summary.render_s += seconds_since(start);
    drop_images(options, i, batch.back());
    if (batch.size() == kBatch || i + 1 == summary.frames) {
      const auto write_start = Clock::now();
      writer.add_frames(batch);
      summary.write_s += seconds_since(write_start);
      batch.clear();
    }
    if (progress) progress(i + 1, summary.frames);
  }
  writer.close();
  summary.render_s /= static_cast<double>(summary.frames);
  summary.write_s /= static_cast<double>(summary.frames);
  return summary;
}

}  // namespace imslam::simulation
