#include "slam/training/pose_head_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"
#include "vo_net/scale_corrector.hpp"

namespace imslam::training {
namespace {

constexpr int kSeedOffset = 1'000'003;  // validation fields are others
constexpr std::size_t kGroup = 16;      // fields on one tape
constexpr double kDegrees = 180.0 / M_PI;

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

Eigen::Vector3d row3(const nn::Tape<float>& tape, nn::Var v, nn::Index row) {
  const float* const x = tape.data(v) + 3 * row;
  return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

}  // namespace

struct PoseHeadValidation::Errors {
  double loss = 0.0;
  std::vector<double> rotation, direction, translation, rotation_normalised, direction_normalised;

  void add(const nn::Tape<float>& tape,
           const vo::PoseHeadOutput& answer,
           nn::Index n,
           const FlowField& field) {
    const Eigen::Vector3d theta = row3(tape, answer.rotation, n);
    const lie::SO3d R = lie::SO3d::exp(theta);
    const lie::SO3d& R_true = field.T_left0_left1.rotation();
    rotation.push_back((R.inverse() * R_true).log().norm() * kDegrees * 1000.0);
    const Eigen::Vector3d off = theta - R_true.log();
    const Eigen::Vector3d log_sigma = row3(tape, answer.log_sigma_rotation, n);
    for (int i = 0; i < 3; ++i) {
      rotation_normalised.push_back(std::abs(off[i]) * std::exp(-log_sigma[i]));
    }
    const Eigen::Vector3d& p = field.T_left0_left1.translation();
    if (!(p.norm() > 0.0)) return;
    const Eigen::Vector3d d = row3(tape, answer.direction, n).normalized();
    const double chord = (d - p.normalized()).norm();
    direction.push_back(2.0 * std::asin(std::min(1.0, 0.5 * chord)) * kDegrees);
    direction_normalised.push_back(
        chord * std::exp(-static_cast<double>(tape.data(answer.log_sigma_direction)[n])));
    const vo::ScaleResult scale =
        correct_scale(field.correspondences, field.camera, {R, d}, vo::ScaleOptions());
    translation.push_back(100.0 * (scale.scale * d - p).norm() / p.norm());
  }

  void append(const Errors& other) {
    loss += other.loss;
    for (auto list : {&Errors::rotation, &Errors::direction, &Errors::translation,
                      &Errors::rotation_normalised, &Errors::direction_normalised}) {
      (this->*list).insert((this->*list).end(), (other.*list).begin(), (other.*list).end());
    }
  }
};

std::string PoseHeadQuality::text() const {
  return fmt::format(
      "loss {:.4f}; rotation {:.1f} mdeg (90 %: {:.1f}), direction {:.2f} deg (90 %: {:.1f}), "
      "translation {:.1f} %, error/sigma {:.2f} and {:.2f}",
      loss, rotation_mdeg, rotation_mdeg_90, direction_deg, direction_deg_90, translation_percent,
      rotation_normalised, direction_normalised);
}

std::string PoseHeadQuality::columns() {
  return "rotation_mdeg,rotation_mdeg_90,direction_deg,direction_deg_90,translation_percent,"
         "rotation_normalised,direction_normalised";
}

std::string PoseHeadQuality::row() const {
  return fmt::format("{:.3f},{:.3f},{:.4f},{:.4f},{:.3f},{:.4f},{:.4f}", rotation_mdeg,
                     rotation_mdeg_90, direction_deg, direction_deg_90, translation_percent,
                     rotation_normalised, direction_normalised);
}

PoseHeadValidation::PoseHeadValidation(const PoseHeadTrainingOptions& options) : options_(options) {
  FlowFieldOptions others = options.flow;
  others.seed += kSeedOffset;
  const FlowFieldGenerator generator(others);
  const auto count = static_cast<std::size_t>(options.validation_samples);
  groups_.resize((count + kGroup - 1) / kGroup);
  parallel_for(groups_.size(), [&](std::size_t g) {
    for (std::size_t i = g * kGroup; i < std::min(count, (g + 1) * kGroup); ++i) {
      groups_[g].push_back(generator.make(i));
    }
  });
}

PoseHeadValidation::Errors PoseHeadValidation::evaluate_group(const vo::PoseHead<float>& network,
                                                              std::size_t group) const {
  const std::vector<FlowField>& fields = groups_[group];
  const PoseHeadSample sample = pose_head_sample(fields);
  nn::Tape<float> tape(nn::Mode::kInference);
  const auto looks = network.forward(tape, tape.constant(sample.grids));
  Errors errors;
  const nn::Var loss = pose_head_loss(tape, looks, sample.truth, options_.early_weight);
  errors.loss = static_cast<double>(tape.number(loss)) * static_cast<double>(fields.size());
  for (std::size_t n = 0; n < fields.size(); ++n) {
    errors.add(tape, looks.back(), static_cast<nn::Index>(n), fields[n]);
  }
  return errors;
}

PoseHeadQuality PoseHeadValidation::evaluate(const vo::PoseHead<float>& network) const {
  std::vector<Errors> each(groups_.size());
  parallel_for(groups_.size(), [&](std::size_t g) { each[g] = evaluate_group(network, g); });
  Errors all;
  for (const Errors& errors : each) all.append(errors);
  PoseHeadQuality quality;
  quality.loss = all.loss / static_cast<double>(options_.validation_samples);
  quality.rotation_mdeg = quantile(all.rotation, 0.5);
  quality.rotation_mdeg_90 = quantile(all.rotation, 0.9);
  quality.direction_deg = quantile(all.direction, 0.5);
  quality.direction_deg_90 = quantile(all.direction, 0.9);
  quality.translation_percent = quantile(all.translation, 0.5);
  quality.rotation_normalised = quantile(all.rotation_normalised, 0.5);
  quality.direction_normalised = quantile(all.direction_normalised, 0.5);
  return quality;
}

}  // namespace imslam::training
