#include "slam/system/inertial_front_end.hpp"

namespace imslam::system {

ImuSample InertialFrontEnd::add(const ImuSample& sample) {
  corrector_.correct(sample);
  const imu::ImuCorrection* const said = corrector_.correction();
  if (said == nullptr) return sample;
  if (beliefs_.empty() || said->time_ns != believed_ns_) believe(*said);
  ImuSample result = sample;
  result.gyro_variance = said->edge_noise.gyro;
  result.accel_variance = said->edge_noise.accel;
  return result;
}

ImuBias InertialFrontEnd::bias() const {
  const imu::ImuCorrection* const said = corrector_.correction();
  return said != nullptr ? said->offset : ImuBias();
}

void InertialFrontEnd::believe(const imu::ImuCorrection& said) {
  believed_ns_ = said.time_ns;
  const bool first = beliefs_.empty();
  if (first) beliefs_.resize(6);
  for (int axis = 0; axis < 6; ++axis) {
    const bool gyro = axis < 3;
    const double sigma = (gyro ? said.sigma.gyro : said.sigma.accel)[axis % 3];
    BiasBelief& belief = beliefs_[static_cast<std::size_t>(axis)];
    if (!first && sigma >= belief.sigma) continue;
    belief = {axis, said.time_ns, (gyro ? said.offset.gyro : said.offset.accel)[axis % 3], sigma};
  }
}

}  // namespace imslam::system
