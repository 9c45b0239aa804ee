#pragma once

#include <string>
#include <vector>

#include "slam/training/pose_head_options.hpp"
#include "slam/training/pose_head_sample.hpp"

namespace imslam::training {

/// How well the answers agree with the truth; of the fields with translation all but the rotation.
struct PoseHeadQuality {
  double loss = 0.0;                  ///< mean over all fields, as in training
  double rotation_mdeg = 0.0;         ///< median angle [0.001 deg]
  double rotation_mdeg_90 = 0.0;      ///< 90 of 100 are below
  double direction_deg = 0.0;         ///< median angle
  double direction_deg_90 = 0.0;      ///< 90 of 100 are below
  double translation_percent = 0.0;   ///< median error of s d, s from correct_scale, of the length
  double rotation_normalised = 0.0;   ///< median |component error| / sigma; 0.74 is right
  double direction_normalised = 0.0;  ///< median chord / sigma; 1.29 is right

  std::string text() const;  ///< one line
  std::string row() const;   ///< all figures but the loss, comma separated
  static std::string columns();
};

/// A fixed set of fields from seeds that training never draws: what chooses among weights.
class PoseHeadValidation {
 public:
  explicit PoseHeadValidation(const PoseHeadTrainingOptions& options);

  PoseHeadQuality evaluate(const vo::PoseHead<float>& network) const;

 private:
  struct Errors;
  Errors evaluate_group(const vo::PoseHead<float>& network, std::size_t group) const;

  PoseHeadTrainingOptions options_;
  std::vector<std::vector<FlowField>> groups_;
};

}  // namespace imslam::training
