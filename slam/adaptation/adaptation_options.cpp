#include "slam/adaptation/adaptation_options.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"
#include "vo_net/options_check.hpp"

namespace imslam::adaptation {
AdaptationOptions::AdaptationOptions() {
  rate = 3e-4;
  warm_up = 4;
  average = 0.0;  // what is looked at is what goes on learning: one run serves both
  patience = 0;
}

void AdaptationOptions::describe(Config& config) {
  config.field("epochs", epochs, "imperative iterations: run, solve the graph, teach");
  config.field("steps_per_epoch", steps_per_epoch, "of the optimiser per solution of the graph");
  config.field("edges", edges, "motions of vision per step");
  config.field("seed", seed, "of the choice of motions");
  config.field("rate", rate, "learning rate after the warm-up, then half a cosine to 0");
  config.field("warm_up", warm_up, "[steps]");
  config.field("weight_decay", weight_decay, "of AdamW");
  config.field("clip", clip, "largest norm of the gradient of one network");
  config.field("patience", patience, "epochs without gain after which it ends; 0: never");
  config.field("guard", guard, "the given weights are the result unless the loss gains on them");
  config.field("matcher", matcher, {"off", "heads", "all"}, "what learns of the matching network");
  config.field("recall_matches", recall_matches,
               "a matching network that does not learn is asked once, not in every epoch");
  config.field("motion_noise", motion_noise, "the covariance of motions learns");
  config.field("pose_head", pose_head, "the pose head learns, where there is one");
  config.field("imu", imu, "the IMU network learns, where there is one");
  config.field("imu_layers", imu_layers, {"all", "last", "offset"},
               "what learns of it: all, its last layer and the sensor's own offset, or that alone");
  config.field("calibration", calibration, {"auto", "on", "off"},
               "what the graph says of the device (focal length, disparity offset, clock) is kept; "
               "auto: with the geometric head");
  config.field("camera_rotation", camera_rotation,
               "and of how the camera is turned against the IMU");
  config.field("upper", upper, {"left_out", "joint", "published"},
               "each measurement against what the others foretell, the graph's own cost, or the "
               "published one over vision alone");
  config.field("strategy", strategy, {"one_step", "implicit"},
               "how the gradient of upper: published goes through the solver");
  config.field("published_weight", published_weight,
               "of upper: published, 1 for KITTI, 4 for EuRoC");
  config.field(
      "loop_weight", loop_weight,
      "of one more upper cost, the likelihood of loops at the solution; implicit, 0: none");
  config.field("loop_span_s", loop_span_s, "motions that span as long close a loop [s]");
  config.field("graph_weight", graph_weight, "of the motions' likelihood under the graph");
  config.field("match_weight", match_weight, "of the matches' likelihood at the graph's motions");
  config.field("imu_weight", imu_weight, "of the inertial likelihoods");
  config.field("rehearsals", rehearsals,
               "simulated logs of other sensors per step, so that the IMU network forgets none");
  config.field("rehearsal_weight", rehearsal_weight, "of their likelihoods, together");
  config.field("imu_rate", imu_rate, "learning rate of the IMU network beside the matcher's");
  config.field("noise_rate", noise_rate, "learning rate of motion_noise beside the matcher's");
  config.field("held_out", held_out, "share of the frames that no network learns from [1]");
  config.field("stretch", stretch, "frames that are held out in a row");
  config.field("imu_crop_s", imu_crop_s, "of the log per step [s]");
  config.field("online_every", online_every, "frames between two steps of online adaptation");
  config.field("online_rate", online_rate, "learning rate of online adaptation");
  config.field("online_memory_s", online_memory_s, "inertial past that it learns from [s]");
}

void AdaptationOptions::validate() const {
  vo::require(epochs >= 1, "finetune.epochs", epochs, "1 or more");
  vo::require(steps_per_epoch >= 1, "finetune.steps_per_epoch", steps_per_epoch, "1 or more");
  vo::require(edges >= 1 && edges <= 4096, "finetune.edges", edges, "1 .. 4096");
  vo::require(held_out > 0.0 && held_out <= 0.5, "finetune.held_out", held_out,
              "above 0, at most 0.5");
  vo::require(stretch >= 2, "finetune.stretch", stretch, "2 or more");
  vo::require(published_weight > 0.0, "finetune.published_weight", published_weight, "> 0");
  if (strategy != "one_step" && upper != "published") {
    throw InputError(
        "finetune.strategy: implicit is of finetune.upper: published; the other upper costs have "
        "their whole gradient in one step",
        ExitCode::kUsage);
  }
  vo::require(loop_weight >= 0.0, "finetune.loop_weight", loop_weight, ">= 0");
  vo::require(loop_span_s > 0.0, "finetune.loop_span_s", loop_span_s, "> 0");
  vo::require(graph_weight >= 0.0, "finetune.graph_weight", graph_weight, ">= 0");
  vo::require(match_weight >= 0.0, "finetune.match_weight", match_weight, ">= 0");
  vo::require(imu_weight >= 0.0, "finetune.imu_weight", imu_weight, ">= 0");
  vo::require(rehearsals >= 0 && rehearsals <= 64, "finetune.rehearsals", rehearsals, "0 .. 64");
  vo::require(rehearsal_weight >= 0.0, "finetune.rehearsal_weight", rehearsal_weight, ">= 0");
  vo::require(imu_rate > 0.0, "finetune.imu_rate", imu_rate, "> 0");
  vo::require(noise_rate > 0.0, "finetune.noise_rate", noise_rate, "> 0");
  vo::require(imu_crop_s >= 5.0, "finetune.imu_crop_s", imu_crop_s, "5 or more");
  vo::require(online_every >= 1, "finetune.online_every", online_every, "1 or more");
  vo::require(online_rate > 0.0, "finetune.online_rate", online_rate, "> 0");
  vo::require(online_memory_s >= 5.0, "finetune.online_memory_s", online_memory_s, "5 or more");
  completed().validate_training("finetune");
}

AdaptationOptions AdaptationOptions::completed() const {
  AdaptationOptions all = *this;
  all.steps = epochs * steps_per_epoch;
  all.batch = lessons_per_step();
  all.validation_every = steps_per_epoch;
  all.checkpoint_every = 1;
  all.warm_up = std::min(warm_up, all.steps - 1);
  return all;
}

bool is_held_out(std::size_t frame, const AdaptationOptions& options) {
  const auto cycle = static_cast<std::size_t>(std::lround(1.0 / options.held_out));
  const std::size_t stretch = frame / static_cast<std::size_t>(options.stretch);
  return stretch % cycle == cycle / 2;
}

}  // namespace imslam::adaptation
