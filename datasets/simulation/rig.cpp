#include "datasets/simulation/rig.hpp"

#include <cmath>

namespace imslam::simulation {
namespace {

struct Preset {
  Distortion model;
  int width;
  int height;
  Eigen::Vector4d intrinsics;
  std::array<double, 4> coefficients;
  double baseline_m;
};

// Calibrations published with the data sets (EuRoC MH_01 cam0, TUM-VI room1 cam0, KITTI 00).
Preset preset_named(const std::string& name) {
  if (name == "tumvi") {
    return {Distortion::kEquidistant,
            512,
            512,
            {190.98, 190.97, 254.93, 256.90},
            {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673},
            0.101};
  }
  if (name == "kitti") {
    return {Distortion::kRadTan, 1241, 376, {718.856, 718.856, 607.193, 185.216}, {}, 0.537};
  }
  return {Distortion::kRadTan,
          752,
          480,
          {458.654, 457.296, 367.215, 248.375},
          {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05},
          0.110};
}

Lens scaled_lens(const Preset& preset,
                 const CameraOptions& options,
                 Random& random,
                 double spread) {
  const double scale = options.width > 0 ? static_cast<double>(options.width) / preset.width : 1.0;
  const int width = options.width > 0 ? options.width : preset.width;
  const int height =
      options.height > 0 ? options.height : static_cast<int>(std::lround(scale * preset.height));
  Eigen::Vector4d k = preset.intrinsics * scale;
  k.head<2>() *= options.focal_scale * (1.0 + 0.003 * spread * random.normal());
  // Keep pixel centres in place when the image is scaled, and the centre when it is cropped.
  k[2] = scale * (preset.intrinsics[2] + 0.5) - 0.5 + scale * spread * 3.0 * random.normal();
  k[3] = scale * (preset.intrinsics[3] + 0.5) - 0.5 + scale * spread * 3.0 * random.normal() +
         0.5 * (height - scale * preset.height);
  std::array<double, 4> coefficients = preset.coefficients;
  for (double& c : coefficients) {
    c *= options.distortion_scale * (1.0 + 0.01 * spread * random.normal());
  }
  return Lens(preset.model, width, height, k, coefficients);
}

lie::SO3d small_rotation(Random& random, double sigma_deg) {
  return lie::SO3d::exp(random.normal3() * (sigma_deg * M_PI / 180.0));
}

}  // namespace

StereoRig make_rig(const CameraOptions& options, Random random) {
  const Preset preset = preset_named(options.preset);
  StereoRig rig;
  rig.left = scaled_lens(preset, options, random, 0.0);
  rig.right = scaled_lens(preset, options, random, options.misalignment_deg > 0.0 ? 1.0 : 0.0);

  Eigen::Matrix3d axes;  // columns: the camera's x, y, z in the body
  axes << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const double baseline = options.baseline_m > 0.0 ? options.baseline_m : preset.baseline_m;
  const lie::SO3d R_body_left =
      small_rotation(random, options.mounting_deg) * lie::SO3d::from_matrix(axes);
  rig.T_body_left = lie::SE3d(R_body_left, Eigen::Vector3d(0.03, 0.5 * baseline, 0.015));

  // The offset across the baseline is a few tenths of a millimetre in real heads.
  const double slack = options.misalignment_deg > 0.0 ? 3e-4 : 0.0;
  const Eigen::Vector3d offset = Eigen::Vector3d(baseline, 0, 0) + slack * random.normal3();
  rig.T_body_right =
      rig.T_body_left * lie::SE3d(small_rotation(random, options.misalignment_deg), offset);
  return rig;
}

}  // namespace imslam::simulation
