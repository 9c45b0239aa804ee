#include "slam/evaluation/names.hpp"

#include <fmt/format.h>

namespace imslam::evaluation {

const std::map<std::string, Relation>& relation_names() {
  static const std::map<std::string, Relation> kNames = {
      {"translation_part", Relation::kTranslationPart},
      {"rotation_part", Relation::kRotationPart},
      {"full_transformation", Relation::kFullTransformation},
      {"rotation_angle_deg", Relation::kRotationAngleDeg},
      {"rotation_angle_rad", Relation::kRotationAngleRad},
      {"point_distance", Relation::kPointDistance},
      {"point_distance_error_ratio", Relation::kPointDistanceErrorRatio}};
  return kNames;
}

const std::map<std::string, Alignment>& alignment_names() {
  static const std::map<std::string, Alignment> kNames = {
      {"none", Alignment::kNone},   {"se3", Alignment::kSe3},       {"sim3", Alignment::kSim3},
      {"scale", Alignment::kScale}, {"origin", Alignment::kOrigin}, {"posyaw", Alignment::kPosYaw}};
  return kNames;
}

const std::map<std::string, DeltaUnit>& delta_unit_names() {
  static const std::map<std::string, DeltaUnit> kNames = {{"frames", DeltaUnit::kFrames},
                                                          {"meters", DeltaUnit::kMeters},
                                                          {"degrees", DeltaUnit::kDegrees},
                                                          {"radians", DeltaUnit::kRadians}};
  return kNames;
}

std::string words_for(Relation relation) {
  switch (relation) {
    case Relation::kTranslationPart:
      return "translation part";
    case Relation::kRotationPart:
      return "rotation part";
    case Relation::kFullTransformation:
      return "full transformation";
    case Relation::kRotationAngleDeg:
      return "rotation angle in degrees";
    case Relation::kRotationAngleRad:
      return "rotation angle in radians";
    case Relation::kPointDistance:
      return "point distance";
    case Relation::kPointDistanceErrorRatio:
      break;
  }
  return "point distance error ratio";
}

std::string unit_of(Relation relation) {
  switch (relation) {
    case Relation::kTranslationPart:
    case Relation::kPointDistance:
      return "m";
    case Relation::kRotationAngleDeg:
      return "deg";
    case Relation::kRotationAngleRad:
      return "rad";
    case Relation::kPointDistanceErrorRatio:
      return "%";
    case Relation::kRotationPart:
    case Relation::kFullTransformation:
      break;
  }
  return "unit-less";
}

std::string delta_text(const DeltaOptions& options) {
  std::string delta = fmt::format("{}", options.delta);
  if (options.unit != DeltaUnit::kFrames && delta.find_first_of(".e") == std::string::npos) {
    delta += ".0";
  }
  const char* const units[] = {"frames", "m", "deg", "rad"};
  return fmt::format("delta = {} ({})", delta, units[static_cast<int>(options.unit)]);
}

std::string evo_title(Relation relation,
                      const AlignmentOptions& alignment,
                      const DeltaOptions* delta,
                      const std::string& projection) {
  std::string title = fmt::format("{} w.r.t. {} ({})", delta != nullptr ? "RPE" : "APE",
                                  words_for(relation), unit_of(relation));
  if (delta != nullptr) {
    title += fmt::format("\nfor {} using {} pairs", delta_text(*delta),
                         delta->all_pairs ? "all" : "consecutive");
  }
  static const std::map<Alignment, const char*> kWords = {
      {Alignment::kNone, "(not aligned)"},
      {Alignment::kSe3, "(with SE(3) Umeyama alignment)"},
      {Alignment::kSim3, "(with Sim(3) Umeyama alignment)"},
      {Alignment::kScale, "(scale corrected)"},
      {Alignment::kOrigin, "(with origin alignment)"},
      {Alignment::kPosYaw, "(with yaw and translation alignment)"}};
  title += std::string("\n") + kWords.at(alignment.kind);
  const bool fits_positions =
      alignment.kind != Alignment::kNone && alignment.kind != Alignment::kOrigin;
  if (alignment.first > 0 && fits_positions) {
    title += fmt::format(" (aligned poses: {})", alignment.first);
  }
  if (!projection.empty()) title += fmt::format("\n(projected to {} plane)", projection);
  return title;
}

}  // namespace imslam::evaluation
