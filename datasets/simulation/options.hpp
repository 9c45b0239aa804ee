#pragma once

#include <string>

namespace imslam {
class Config;
}

namespace imslam::simulation {

/// The stereo head. A preset gives lens and baseline of a known rig; single values override it.
struct CameraOptions {
  std::string preset = "euroc";   ///< euroc: 752x480 radtan; tumvi: 512x512 equidistant;
                                  ///< kitti: 1241x376 without distortion
  int width = 0;                  ///< [px], 0: of the preset; the focal length scales along
  int height = 0;                 ///< [px], 0: of the preset, scaled like the width
  double focal_scale = 1.0;       ///< times the preset's focal length
  double distortion_scale = 1.0;  ///< times the preset's coefficients; 0: none
  double baseline_m = 0.0;        ///< [m], 0: of the preset
  double misalignment_deg = 0.3;  ///< sigma of the rotation between left and right, per axis
  double mounting_deg = 1.0;      ///< sigma of the rotation between body and camera, per axis

  void describe(Config& config);
  void validate() const;
};

/// From radiance to 8-bit pixels.
struct ImageOptions {
  double exposure_ms = 6.0;         ///< motion blur; 0: none
  bool auto_exposure = true;        ///< gain follows the mean brightness with a lag
  double exposure_steps = 0.0;      ///< sudden gain changes per minute
  double brightness = 0.42;         ///< mean of the image that exposure aims at, of full scale
  double right_gain_percent = 2.0;  ///< sigma of the right camera's gain error
  double vignetting = 0.3;          ///< loss of light in the corners
  double noise_scale = 1.0;         ///< times shot and read noise; 0: none
  double read_noise = 0.9;          ///< sigma [grey levels]
  double shot_noise = 0.018;        ///< variance per grey level [grey levels]

  void describe(Config& config);
  void validate() const;
};

/// The inertial sensor. A grade gives typical datasheet errors.
struct ImuOptions {
  std::string grade = "industrial";  ///< perfect, tactical, industrial (ADIS16448, as in EuRoC),
                                     ///< mems, phone
  double rate_hz = 200.0;            ///< [Hz]
  double noise_scale = 1.0;          ///< times white noise and bias walk
  double bias_scale = 1.0;           ///< times the initial bias
  double shape_scale = 1.0;          ///< times scale factor and misalignment errors
  double g_sensitivity_scale = 0.0;  ///< times what the grade's gyro reads per specific force
  double temperature_scale = 0.0;    ///< times the grade's change of bias while warming up
  double vibration = 0.0;            ///< [m/s^2] rms per axis while the vehicle runs, of rotors,
                                     ///< engine, road
  double gyro_range = 0.0;           ///< [rad/s], 0: of the grade
  double accel_range = 0.0;          ///< [m/s^2], 0: of the grade
  bool quantise = false;             ///< round readings to the grade's 16-bit steps
  double camera_delay_s = 0.0;       ///< [s] t_imu = t_camera + camera_delay_s

  void describe(Config& config);
  void validate() const;
};

/// Everything that decides a simulated sequence: equal options give equal bytes, given the same
/// texture bank.
struct SimulationOptions {
  std::string scene = "room";      ///< room, corridor, forest, street
  std::string motion = "natural";  ///< natural, static, pure_rotation, free_fall
  std::string textures = "auto";   ///< procedural, photos, auto: photos where there are some
  int seed = 1;
  double duration_s = 15.0;         ///< [s]
  double rest_s = 1.5;              ///< [s] standing still at the start
  double speed = 1.0;               ///< times the usual speed of the scene family
  double frame_rate_hz = 20.0;      ///< [Hz]
  bool dynamic_objects = true;      ///< cars that drive (street)
  bool antialias = true;            ///< extra rays at edges
  bool truth_depth = false;         ///< write mav0/depth0
  bool truth_flow = false;          ///< write mav0/flow0, left camera, frame k to k + 1
  double drop_left_percent = 0.0;   ///< left images that are missing from the folder
  double drop_right_percent = 0.0;  ///< right images that are missing from the folder
  bool force = false;               ///< write into a folder that is not empty
  CameraOptions camera;
  ImageOptions image;
  ImuOptions imu;

  void describe(Config& config);
  /// Throws InputError(kUsage) that names key, value and bound.
  void validate() const;
};

/// The embedded default sequence: a hand-held flight through a room. Procedural textures only, so
/// that it is the same on every machine.
SimulationOptions default_sequence_options();

}  // namespace imslam::simulation
