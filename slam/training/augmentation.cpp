#include "slam/training/augmentation.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::training {
namespace {

/// Uniform between the logarithms, which the ramp pulls towards 1.
float draw_factor(Random& random, double low, double high, double ramp) {
  return static_cast<float>(std::exp(ramp * random.uniform(std::log(low), std::log(high))));
}

/// In [0, most ramp]; small values are commoner.
float draw_strength(Random& random, double most, double ramp, double power) {
  return static_cast<float>(most * ramp * std::pow(random.uniform(), power));
}

/// Applies `change` to the three views.
template <typename Change>
void for_each_view(TripletDegradation& d, const Change& change) {
  change(d.left0);
  change(d.right0);
  change(d.left1);
}

MotionBlur draw_motion_blur(Random& random, double most, double ramp) {
  const float length = draw_strength(random, most, ramp, 1.5);
  const double direction = random.uniform(-M_PI, M_PI);
  const float varying = 0.5F * length * static_cast<float>(random.uniform());
  const auto slope = [&] { return varying * static_cast<float>(random.uniform(-1.0, 1.0)); };
  MotionBlur blur;
  blur.u = length * static_cast<float>(std::cos(direction));
  blur.v = length * static_cast<float>(std::sin(direction));
  blur.u_x = slope();
  blur.u_y = slope();
  blur.v_x = slope();
  blur.v_y = slope();
  return blur;
}

void draw_light(const AugmentationOptions& o, double ramp, Random random, TripletDegradation& d) {
  if (random.chance(o.haze_share)) {
    const float haze = draw_strength(random, o.haze, ramp, 1.0);
    const auto airlight = static_cast<float>(random.uniform(60.0, 255.0));
    for_each_view(d, [&](ViewDegradation& view) {
      view.haze = haze * static_cast<float>(random.uniform(0.85, 1.0));
      view.airlight = airlight;
    });
  }
  if (random.chance(o.dark_share)) {
    const float darkness = draw_factor(random, o.darkest, 1.0, ramp);
    // Cameras in the dark amplify, more or less.
    const float amplified =
        random.chance(0.5) ? static_cast<float>(random.uniform(0.3, 1.0)) : 0.0F;
    for_each_view(d, [&](ViewDegradation& view) {
      view.darkness = darkness;
      view.amplification = std::pow(darkness, -amplified);
    });
  }
  if (random.chance(o.exposure_share)) {
    const float gain = draw_factor(random, o.least_gain, o.most_gain, ramp);
    if (random.chance(0.5)) {
      d.left1.gain = gain;
    } else {
      d.left0.gain = d.right0.gain = gain;
    }
    // The right camera follows the left one, mostly.
    if (random.chance(0.3))
      d.right0.gain = draw_factor(random, std::sqrt(o.least_gain), std::sqrt(o.most_gain), ramp);
  }
}

void draw_lens(const AugmentationOptions& o, double ramp, Random random, TripletDegradation& d) {
  if (random.chance(o.motion_blur_share)) {
    d.left0.motion = d.right0.motion = draw_motion_blur(random, o.motion_blur, ramp);
    // The hand shakes on, or does not; a sudden smear of one instant is the hard case.
    if (random.chance(0.7)) d.left1.motion = draw_motion_blur(random, o.motion_blur, ramp);
    if (random.chance(0.3)) d.left0.motion = d.right0.motion = MotionBlur();
  }
  if (random.chance(o.defocus_share)) {
    for_each_view(d, [&](ViewDegradation& view) {
      view.defocus.sigma = draw_strength(random, o.defocus, ramp, 1.5);
      view.defocus.share_x = static_cast<float>(random.uniform(-1.0, 1.0));
      view.defocus.share_y = static_cast<float>(random.uniform(-1.0, 1.0));
    });
  }
  if (random.chance(o.vignetting_share)) {
    const float vignetting = draw_strength(random, o.vignetting, ramp, 1.0);
    for_each_view(d, [&](ViewDegradation& view) {
      view.vignetting = vignetting * static_cast<float>(random.uniform(0.8, 1.0));
    });
    d.left0.vignette_x = d.left1.vignette_x = static_cast<float>(random.uniform(-0.3, 0.3));
    d.left0.vignette_y = d.left1.vignette_y = static_cast<float>(random.uniform(-0.3, 0.3));
    d.right0.vignette_x = static_cast<float>(random.uniform(-0.3, 0.3));
    d.right0.vignette_y = static_cast<float>(random.uniform(-0.3, 0.3));
  }
}

void draw_sensor(const AugmentationOptions& o, double ramp, Random random, TripletDegradation& d) {
  if (random.chance(o.noise_share)) {
    const float read = draw_strength(random, o.read_noise, ramp, 3.0);
    const float shot = draw_strength(random, o.shot_noise, ramp, 3.0);
    for_each_view(d, [&](ViewDegradation& view) {
      const auto own = static_cast<float>(random.uniform(0.6, 1.0));
      view.read_noise = own * read;
      view.shot_noise = own * shot;
    });
  }
  if (random.chance(o.gamma_share)) {
    const float gamma = draw_factor(random, 1.0 / o.most_gamma, o.most_gamma, ramp);
    for_each_view(d, [&](ViewDegradation& view) { view.gamma = gamma; });
  }
  if (random.chance(o.hot_pixel_share)) {
    const float most = draw_strength(random, o.hot_pixels, ramp, 2.0);
    for_each_view(d, [&](ViewDegradation& view) { view.hot_pixels = static_cast<int>(most); });
    d.left0.hot_seed = d.left1.hot_seed = random.bits();
    d.right0.hot_seed = random.bits();
  }
  for (std::uint64_t& seed : d.noise_seeds) seed = random.bits();
  for_each_view(d, [&](ViewDegradation& view) { view.quantise = ramp > 0.0; });
}

std::vector<Occluder> draw_occluders(
    const AugmentationOptions& o, double ramp, int width, int height, Random random) {
  std::vector<Occluder> occluders;
  if (o.occluders == 0 || !random.chance(ramp * o.occluder_share)) return occluders;
  const auto count = random.integer(1, o.occluders);
  for (std::int64_t i = 0; i < count; ++i) {
    Occluder occluder;
    occluder.width = width * std::exp(random.uniform(std::log(0.03), std::log(0.35)));
    occluder.height = height * std::exp(random.uniform(std::log(0.04), std::log(0.5)));
    occluder.x = random.uniform(-0.5 * occluder.width, width - 0.5 * occluder.width);
    occluder.y = random.uniform(-0.5 * occluder.height, height - 0.5 * occluder.height);
    occluder.disparity = random.uniform(1.0, o.occluder_disparity);
    occluder.flow_u = o.occluder_flow * random.normal();
    occluder.flow_v = o.occluder_flow * random.normal();
    const bool dark = random.chance(0.5);
    occluder.grey =
        static_cast<float>(dark ? random.uniform(0.0, 50.0) : random.uniform(190.0, 255.0));
    occluders.push_back(occluder);
  }
  return occluders;
}

}  // namespace

Augmentation::Augmentation(const AugmentationOptions& options) : options_(options) {
  options_.validate();
}

TripletDegradation Augmentation::draw(std::uint64_t index,
                                      double ramp,
                                      int width,
                                      int height) const {
  expects(ramp >= 0.0 && ramp <= 1.0, "Augmentation: ramp must lie in [0, 1]");
  const Random random = Random(static_cast<std::uint64_t>(options_.seed)).fork(index);
  TripletDegradation degradation;
  draw_light(options_, ramp, random.fork(1), degradation);
  draw_lens(options_, ramp, random.fork(2), degradation);
  draw_sensor(options_, ramp, random.fork(3), degradation);
  degradation.occluders = draw_occluders(options_, ramp, width, height, random.fork(4));
  return degradation;
}

void Augmentation::apply(std::uint64_t index, double ramp, Triplet& triplet) const {
  degrade(draw(index, ramp, triplet.camera.width, triplet.camera.height), triplet);
}

void degrade(const TripletDegradation& d, Triplet& triplet) {
  const int width = triplet.camera.width;
  const int height = triplet.camera.height;
  add_occluders(d.occluders, triplet);
  degrade(d.left0, width, height, d.noise_seeds[0], triplet.left0);
  degrade(d.right0, width, height, d.noise_seeds[1], triplet.right0);
  degrade(d.left1, width, height, d.noise_seeds[2], triplet.left1);
}

}  // namespace imslam::training
