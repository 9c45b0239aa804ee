#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slam/adaptation/epoch.hpp"
#include "slam/training/inertial_log.hpp"

namespace imslam::adaptation {

/// How good the networks of one epoch are. What needs truth is empty without it.
struct EpochScores {
  double held_out_loss = 0.0;  ///< self-supervised, see GraphTeacher::left_out_loss()
  double learned_loss = 0.0;   ///< the same over the frames that networks learn from
  std::optional<double> vo_ate_m;
  std::optional<double> vo_rpe_m;    ///< [m] per frame
  std::optional<double> vo_rpe_deg;  ///< [deg] per frame
  std::optional<double> graph_ate_m;
  std::optional<double> graph_rpe_m;
  std::optional<double> graph_rpe_deg;
  std::optional<double> imu_rotation_deg;  ///< RMS of open integration over kImuWindow_s
  std::optional<double> imu_position_m;

  /// For another process, bit by bit.
  std::string packed() const;
  static EpochScores unpacked(const std::string& bytes);

  std::string text() const;  ///< one line
  std::string row() const;   ///< comma separated, in the order of columns(); all but the loss
  static std::string columns();
};

inline constexpr double kImuWindow_s = 5.0;

/// Of several sequences, each as much as the others; of each figure over those that have it.
EpochScores mean_of(const std::vector<EpochScores>& all);

/// `truth`: of the inertial sensor, or null; `network`: null for raw readings.
EpochScores score_epoch(const Epoch& epoch,
                        const AdaptationOptions& options,
                        const training::InertialLog* truth,
                        const imu::ImuNetwork<float>* network);

/// The sequence's own truth as an inertial log, from a run that was evaluated. Empty without truth
/// or IMU, or if there is too little of it to tell velocities.
std::optional<training::InertialLog> true_inertial_log(const datasets::Sequence& sequence,
                                                       const system::RunOutcome& outcome);

}  // namespace imslam::adaptation
