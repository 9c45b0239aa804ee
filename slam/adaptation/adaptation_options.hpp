#pragma once

#include <string>

#include "slam/learner/training_options.hpp"

namespace imslam::adaptation {

/// How the graph teaches the networks on a sequence without labels.
///
/// The defaults are for a few minutes of data: what so little of it can teach reliably. (The
/// matching network cannot be bettered by it: it has seen far more in training, and odometry came
/// out worse by 2 to 4 %, see README.) Of learner::TrainingOptions, `steps`, `batch`,
/// `validation_every` and `checkpoint_every` follow from epochs, steps_per_epoch and edges.
struct AdaptationOptions : learner::TrainingOptions {
  AdaptationOptions();

  int epochs = 10;          ///< imperative iterations: run, solve the graph, teach
  int steps_per_epoch = 8;  ///< of the optimiser between two solutions of the graph
  int edges = 16;           ///< motions of vision per step

  std::string matcher = "off";  ///< what learns of the matching network: off, heads, all
  /// A matching network that does not learn is asked once; later epochs get the same matches.
  bool recall_matches = true;
  bool motion_noise = true;  ///< the covariance of motions
  bool pose_head = true;     ///< of vo.head: regression
  bool imu = true;           ///< of system.imu: learned
  /// Of the IMU network: all, last (its last layer and the sensor's own offset), offset (that
  /// alone).
  std::string imu_layers = "all";
  /// What the graph finds of the device (focal length, disparity offset, clock, rotation) is kept:
  /// on, off, or auto: with the geometric head. A head that learns beside it makes both drift.
  std::string calibration = "auto";
  bool camera_rotation = true;  ///< of the camera against the IMU, where calibration is kept

  /// Each measurement against the others, joint: U = L, or published: U over vision alone.
  std::string upper = "left_out";
  std::string strategy = "one_step";  ///< of upper: published, see WholeGradient; or implicit
  double published_weight = 1.0;      ///< [1/m, 1/rad] of upper: published: 1 (KITTI), 4 (EuRoC)
  /// Of one more term of U: the likelihood of the motions that close loops (those that span
  /// loop_span_s or more) at the solution; its gradient follows the states (implicit). 0: none.
  double loop_weight = 0.0;
  double loop_span_s = 2.0;       ///< [s]
  double graph_weight = 1.0;      ///< of the motions' likelihood under the graph, per dimension
  double match_weight = 1.0;      ///< of the matches' likelihood at the graph's motions, per point
  double imu_weight = 1.0;        ///< of the inertial likelihoods, beside one step's motions
  int rehearsals = 2;             ///< simulated logs of other sensors per step, so as not to forget
  double rehearsal_weight = 1.0;  ///< of their likelihoods, together, beside the sequence's own
  double imu_rate = 2.0;          ///< learning rate beside that of the matcher
  double noise_rate = 15.0;       ///< likewise, of motion_noise, which begins with nothing

  double held_out = 0.2;     ///< [1] share of the frames that no network learns from
  int stretch = 20;          ///< [frames] that are held out in a row
  double imu_crop_s = 60.0;  ///< [s] of the log per step

  int online_every = 10;          ///< [frames] between two steps of online adaptation
  double online_rate = 1e-4;      ///< learning rate of it
  double online_memory_s = 60.0;  ///< [s] of the inertial past that it learns from

  int lessons_per_step() const { return edges + 1 + rehearsals; }

  void describe(Config& config);
  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
  /// With what follows from the others.
  AdaptationOptions completed() const;
};

/// Whether a frame belongs to a stretch that is held out: of every 1 / held_out stretches (rounded)
/// the one in the middle.
bool is_held_out(std::size_t frame, const AdaptationOptions& options);

}  // namespace imslam::adaptation
