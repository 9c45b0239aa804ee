#include "slam/training/inertial_log_options.hpp"

#include <string>
#include <utility>

#include "slam/base/config.hpp"
#include "slam/training/bounds.hpp"

namespace imslam::training {

void InertialLogOptions::describe(Config& config) {
  config.field("seed", seed, "decides every log");
  config.field("drone_share", drone_share, "of logs of a multirotor, relative to all shares");
  config.field("hand_share", hand_share, "of logs of a hand-held sensor");
  config.field("car_share", car_share, "of logs of a car");
  config.field("rover_share", rover_share, "of logs of a slow robot on wheels");
  config.field("min_duration_s", min_duration_s, "shortest log [s]");
  config.field("max_duration_s", max_duration_s, "longest log [s]");
  config.field("rate_hz", rate_hz, "samples per second, 0: drawn from 50 to 1000");
  config.field("noise_scale", noise_scale, "times white noise and bias walk");
  config.field("bias_scale", bias_scale, "times the initial bias");
  config.field("shape_scale", shape_scale, "times scale and misalignment errors");
  config.field("g_sensitivity_scale", g_sensitivity_scale, "times the gyro's error per force");
  config.field("temperature_scale", temperature_scale, "times the change of bias at warming up");
  config.field("vibration_scale", vibration_scale, "times what rotors, engine and road add");
  config.field("quantised_share", quantised_share, "of logs rounded to 16 bits");
  config.field("jitter_share", jitter_share, "of logs with jittered stamps");
  config.field("gap_share", gap_share, "of logs with gaps of 0.05 to 1 s");
}

void InertialLogOptions::validate() const {
  require_within("inertial.seed", seed, 0, 2147483647);
  for (const auto& [key, share] :
       {std::pair{"drone_share", drone_share}, std::pair{"hand_share", hand_share},
        std::pair{"car_share", car_share}, std::pair{"rover_share", rover_share}}) {
    require_within(std::string("inertial.") + key, share, 0.0, 1.0);
  }
  require_within("inertial.drone_share + hand_share + car_share + rover_share",
                 drone_share + hand_share + car_share + rover_share, 1e-6, 4.0);
  require_within("inertial.min_duration_s", min_duration_s, 10.0, 3600.0);
  require_within("inertial.max_duration_s", max_duration_s, min_duration_s, 3600.0);
  if (rate_hz != 0.0) require_within("inertial.rate_hz", rate_hz, 50.0, 1000.0);
  for (const auto& [key, scale] :
       {std::pair{"noise_scale", noise_scale}, std::pair{"bias_scale", bias_scale},
        std::pair{"shape_scale", shape_scale},
        std::pair{"g_sensitivity_scale", g_sensitivity_scale},
        std::pair{"temperature_scale", temperature_scale},
        std::pair{"vibration_scale", vibration_scale}}) {
    require_within(std::string("inertial.") + key, scale, 0.0, 100.0);
  }
  require_within("inertial.quantised_share", quantised_share, 0.0, 1.0);
  require_within("inertial.jitter_share", jitter_share, 0.0, 1.0);
  require_within("inertial.gap_share", gap_share, 0.0, 1.0);
}

}  // namespace imslam::training
