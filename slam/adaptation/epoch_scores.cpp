#include "slam/adaptation/epoch_scores.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "imu_net/imu_corrector.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"
#include "slam/training/inertial_methods.hpp"
#include "slam/training/open_integration.hpp"
#include "slam/training/truth_gravity.hpp"
#include "slam/training/truth_jumps.hpp"
#include "slam/training/truth_velocity.hpp"

namespace imslam::adaptation {
namespace {

constexpr double kStride_s = 0.5;
/// In a mean over sequences: far worse than any that teaches, and the others still count.
constexpr double kUnusable = 1e6;

void score_inertial(const training::InertialLog& truth,
                    const imu::ImuNetwork<float>* network,
                    EpochScores& scores) {
  training::InertialMethod method = training::raw_method();
  if (network != nullptr) {
    // correct_samples() shares the network; it lives longer than this call.
    const std::shared_ptr<const imu::ImuNetwork<float>> shared(network, [](const void*) {});
    method = training::corrected_method("network", [shared](const training::InertialLog& log) {
      return imu::correct_samples(shared, log.samples, log.noise);
    });
  }
  training::OpenIntegrationOptions options;
  options.window_s = kImuWindow_s;
  options.stride_s = kStride_s;
  const auto result = training::integrate_open(truth, method.correct(truth).correction, options);
  if (result.windows.empty()) return;
  const training::OpenScore score = training::score(result);
  scores.imu_rotation_deg = score.rotation_rms_deg;
  scores.imu_position_m = score.position_rms;
}

/// What needs truth.
constexpr std::array<std::optional<double> EpochScores::*, 8> kFigures{
    &EpochScores::vo_ate_m,         &EpochScores::vo_rpe_m,      &EpochScores::vo_rpe_deg,
    &EpochScores::graph_ate_m,      &EpochScores::graph_rpe_m,   &EpochScores::graph_rpe_deg,
    &EpochScores::imu_rotation_deg, &EpochScores::imu_position_m};

/// The losses, then the figures; NaN: not known.
using Numbers = std::array<double, 2 + kFigures.size()>;

std::string number(const std::optional<double>& value) {
  return value ? fmt::format("{:.6g}", *value) : std::string();
}

}  // namespace

std::string EpochScores::columns() {
  return "learned_loss,vo_ate_m,vo_rpe_m,vo_rpe_deg,graph_ate_m,graph_rpe_m,graph_rpe_deg,"
         "imu_rotation_deg,imu_position_m";
}

std::string EpochScores::row() const {
  return fmt::format("{:.6g},{},{},{},{},{},{},{},{}", learned_loss, number(vo_ate_m),
                     number(vo_rpe_m), number(vo_rpe_deg), number(graph_ate_m), number(graph_rpe_m),
                     number(graph_rpe_deg), number(imu_rotation_deg), number(imu_position_m));
}

std::string EpochScores::text() const {
  std::string line =
      fmt::format("held-out loss {:.4f}, learned {:.4f}", held_out_loss, learned_loss);
  if (vo_ate_m) line += fmt::format(", VO ATE {:.4g} m", *vo_ate_m);
  if (vo_rpe_m) line += fmt::format(" RPE {:.4g} m {:.4g} deg", *vo_rpe_m, *vo_rpe_deg);
  if (graph_ate_m) line += fmt::format(", graph ATE {:.4g} m", *graph_ate_m);
  if (graph_rpe_m) line += fmt::format(" RPE {:.4g} m {:.4g} deg", *graph_rpe_m, *graph_rpe_deg);
  if (imu_rotation_deg) {
    line += fmt::format(", IMU {:.0f} s {:.4g} deg {:.4g} m", kImuWindow_s, *imu_rotation_deg,
                        *imu_position_m);
  }
  return line;
}

std::string EpochScores::packed() const {
  Numbers numbers{held_out_loss, learned_loss};
  for (std::size_t i = 0; i < kFigures.size(); ++i) {
    numbers[2 + i] = (this->*kFigures[i]).value_or(std::nan(""));
  }
  std::string bytes(sizeof(numbers), '\0');
  std::memcpy(bytes.data(), numbers.data(), sizeof(numbers));
  return bytes;
}

EpochScores EpochScores::unpacked(const std::string& bytes) {
  Numbers numbers{};
  expects(bytes.size() == sizeof(numbers), "EpochScores: bytes of packed()");
  std::memcpy(numbers.data(), bytes.data(), sizeof(numbers));
  EpochScores scores;
  scores.held_out_loss = numbers[0];
  scores.learned_loss = numbers[1];
  for (std::size_t i = 0; i < kFigures.size(); ++i) {
    if (!std::isnan(numbers[2 + i])) scores.*kFigures[i] = numbers[2 + i];
  }
  return scores;
}

EpochScores mean_of(const std::vector<EpochScores>& all) {
  expects(!all.empty(), "mean_of: at least one sequence");
  EpochScores mean;
  const auto count = static_cast<double>(all.size());
  for (const EpochScores& one : all) {
    mean.held_out_loss += std::min(one.held_out_loss, kUnusable) / count;
    mean.learned_loss += std::min(one.learned_loss, kUnusable) / count;
  }
  for (const auto figure : kFigures) {
    double sum = 0.0;
    double known = 0.0;
    for (const EpochScores& one : all) {
      if (one.*figure) sum += *(one.*figure);
      if (one.*figure) known += 1.0;
    }
    if (known > 0.0) mean.*figure = sum / known;
  }
  return mean;
}

EpochScores score_epoch(const Epoch& epoch,
                        const AdaptationOptions& options,
                        const training::InertialLog* truth,
                        const imu::ImuNetwork<float>* network) {
  EpochScores scores;
  if (epoch.teacher) {
    scores.held_out_loss = epoch.teacher->left_out_loss(
        [&](std::size_t state) { return is_held_out(state, options); });
    scores.learned_loss = epoch.teacher->left_out_loss(
        [&](std::size_t state) { return !is_held_out(state, options); });
  } else {
    scores.held_out_loss = scores.learned_loss = 1e300;
  }
  if (epoch.outcome.evaluation) {
    const system::RunEvaluation& evaluation = *epoch.outcome.evaluation;
    scores.vo_ate_m = evaluation.vo.ate_se3_rmse_m;
    scores.vo_rpe_m = evaluation.vo.rpe_frame_rmse_m;
    scores.vo_rpe_deg = evaluation.vo.rpe_frame_rmse_deg;
    scores.graph_ate_m = evaluation.graph.ate_se3_rmse_m;
    scores.graph_rpe_m = evaluation.graph.rpe_frame_rmse_m;
    scores.graph_rpe_deg = evaluation.graph.rpe_frame_rmse_deg;
  }
  if (truth != nullptr) score_inertial(*truth, network, scores);
  return scores;
}

std::optional<training::InertialLog> true_inertial_log(const datasets::Sequence& sequence,
                                                       const system::RunOutcome& outcome) {
  if (!outcome.evaluation || !sequence.imu() || !outcome.result.inertial) return std::nullopt;
  training::InertialLog log;
  log.name = sequence.name();
  log.samples = sequence.imu()->samples;
  log.noise = sequence.imu()->noise;
  const double offset_s = outcome.result.time_offset_s ? outcome.result.time_offset_s->value : 0.0;
  Trajectory poses;
  const Trajectory& truth = outcome.evaluation->truth;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::int64_t time_ns = truth.times_ns[i] + to_nanoseconds(offset_s);
    if (time_ns < log.samples.front().time_ns || time_ns > log.samples.back().time_ns) continue;
    poses.add(time_ns, truth.poses[i]);
  }
  if (poses.size() < 20) return std::nullopt;
  const auto gravity = training::fit_gravity(log.samples, log.noise, poses);
  const auto jumps = training::find_jumps(log.samples, log.noise, poses, gravity);
  const auto velocities = training::fit_velocities(log.samples, log.noise, poses, jumps, gravity);
  log.gravity_world = gravity.gravity_world;
  log.truth_sigma = {1e-3, 5e-4, velocities.sigma, 1e-3};
  auto jump = jumps.begin();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!velocities.known[i]) continue;
    if (jump != jumps.end() && *jump <= i) log.truth_jumps.push_back(log.truth.size());
    while (jump != jumps.end() && *jump <= i) ++jump;
    log.truth.push_back({poses.times_ns[i], {poses.poses[i], velocities.velocities[i]}});
  }
  if (log.truth.size() < 2) return std::nullopt;
  return log;
}

}  // namespace imslam::adaptation
