#include "pgo/options.hpp"

#include <sstream>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"

namespace imslam::pgo {
namespace {

template <typename Value>
void require(bool valid, const char* key, const Value& value, const char* bound) {
  if (valid) return;
  std::ostringstream message;
  message << key << " = " << value << ": expected " << bound;
  throw InputError(message.str(), ExitCode::kUsage);
}

}  // namespace

void GraphOptions::describe(Config& config) {
  config.field("gravity", gravity_magnitude, "magnitude of gravity [m/s^2]");
  config.field("kernel", kernel, {"none", "huber", "cauchy", "cauchy_tail"},
               "robust kernel of visual edges");
  config.field("huber", kernel_width, "kernel width [standard deviations]");
  config.field("estimate_disparity_offset", estimate_disparity_offset,
               "estimate the constant disparity error of the stereo rectification");
  config.field("estimate_focal_error", estimate_focal_error,
               "estimate how far the focal length is off, from vision's and the gyro's turns");
  config.field("estimate_time_offset", estimate_time_offset,
               "estimate the time offset between camera and IMU");
  config.field("estimate_camera_rotation", estimate_camera_rotation,
               "estimate how the camera is turned against the IMU beyond what is stated");
  config.field("estimate_gyro_shape", estimate_gyro_shape,
               "estimate scale errors and axes askew of a gyro that is not known for good ones");
}

void GraphOptions::validate() const {
  require(gravity_magnitude > 0.0 && gravity_magnitude < 100.0, "pgo.gravity", gravity_magnitude,
          "more than 0 and less than 100 m/s^2");
  require(kernel == "none" || kernel == "huber" || kernel == "cauchy" || kernel == "cauchy_tail",
          "pgo.kernel", kernel, "none, huber, cauchy or cauchy_tail");
  require(kernel_width > 0.0 && kernel_width < 1e6, "pgo.huber", kernel_width,
          "more than 0 and less than 1e6");
  require(gyro_random_walk > 0.0 && gyro_random_walk < 1e3, "pgo.gyro_random_walk",
          gyro_random_walk, "more than 0 and less than 1e3");
  require(accel_random_walk > 0.0 && accel_random_walk < 1e3, "pgo.accel_random_walk",
          accel_random_walk, "more than 0 and less than 1e3");
}

void SolverOptions::describe(Config& config) {
  config.field("max_iterations", max_iterations, "most Levenberg-Marquardt steps");
  config.field("function_tolerance", function_tolerance, "relative change of the cost to stop at");
  config.field("gradient_tolerance", gradient_tolerance, "largest gradient entry to stop at");
  config.field("parameter_tolerance", parameter_tolerance, "relative step to stop at");
  config.field("initial_trust_region", initial_trust_region, "first trust region radius");
  config.field("threads", threads, "threads for evaluating factors; the result is the same");
}

void SolverOptions::validate() const {
  require(max_iterations >= 1 && max_iterations <= 100000, "pgo.solver.max_iterations",
          max_iterations, "1 to 100000");
  require(function_tolerance >= 0.0 && function_tolerance < 1.0, "pgo.solver.function_tolerance",
          function_tolerance, "0 or more and less than 1");
  require(gradient_tolerance >= 0.0, "pgo.solver.gradient_tolerance", gradient_tolerance,
          "0 or more");
  require(parameter_tolerance >= 0.0, "pgo.solver.parameter_tolerance", parameter_tolerance,
          "0 or more");
  require(initial_trust_region > 0.0 && initial_trust_region <= 1e16,
          "pgo.solver.initial_trust_region", initial_trust_region, "more than 0, at most 1e16");
  require(threads >= 1 && threads <= 1024, "pgo.solver.threads", threads, "1 to 1024");
}

}  // namespace imslam::pgo
