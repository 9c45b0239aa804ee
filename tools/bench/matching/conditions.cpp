#include "tools/bench/matching/conditions.hpp"

#include <cmath>

#include "slam/base/error.hpp"
#include "slam/training/augmentation.hpp"
#include "tools/bench/matching/moving_patches.hpp"

namespace imslam::bench {
namespace {

using training::TripletDegradation;
using training::ViewDegradation;

constexpr double kPi = 3.14159265358979323846;
constexpr float kReadNoise = 2.0F;   // [grey levels] in the dark
constexpr float kShotNoise = 0.02F;  // [grey levels] variance per grey level

// Streams of a scene's randomness.
constexpr std::uint64_t kNoiseStream = 1;
constexpr std::uint64_t kBlurStream = 2;
constexpr std::uint64_t kPatchStream = 3;

void apply(TripletDegradation degradation, const Random& random, MatchScene& scene) {
  Random seeds = random.fork(kNoiseStream);
  for (std::uint64_t& seed : degradation.noise_seeds) seed = seeds.bits();
  for (ViewDegradation* view : {&degradation.left0, &degradation.right0, &degradation.left1}) {
    view->quantise = true;
  }
  training::degrade(degradation, scene.views);
}

training::MotionBlur smear(double length, double angle) {
  training::MotionBlur blur;
  blur.u = static_cast<float>(length * std::cos(angle));
  blur.v = static_cast<float>(length * std::sin(angle));
  return blur;
}

void blur(MatchScene& scene, double length, const Random& random) {
  Random directions = random.fork(kBlurStream);
  TripletDegradation d;
  d.left0.motion = smear(length, directions.uniform(0.0, kPi));
  d.right0.motion = d.left0.motion;
  d.left1.motion = smear(length, directions.uniform(0.0, kPi));
  apply(d, random, scene);
}

void darken(MatchScene& scene, double light, const Random& random) {
  TripletDegradation d;
  for (ViewDegradation* view : {&d.left0, &d.right0, &d.left1}) {
    view->darkness = static_cast<float>(light);
    view->read_noise = kReadNoise;
    view->shot_noise = kShotNoise;
  }
  apply(d, random, scene);
}

void step_exposure(MatchScene& scene, double factor, const Random& random) {
  TripletDegradation d;
  d.right0.gain = d.left1.gain = static_cast<float>(factor);
  apply(d, random, scene);
}

void add_noise(MatchScene& scene, double sigma, const Random& random) {
  TripletDegradation d;
  for (ViewDegradation* view : {&d.left0, &d.right0, &d.left1}) {
    view->read_noise = static_cast<float>(sigma);
  }
  apply(d, random, scene);
}

void add_moving(MatchScene& scene, double count, const Random& random) {
  add_patches(draw_patches(scene, static_cast<int>(count), random.fork(kPatchStream)), scene);
  apply({}, random, scene);
}

}  // namespace

std::vector<Condition> conditions() {
  return {
      {"motion_blur", "px", {4.0, 8.0, 12.0, 16.0, 21.0}, blur},
      {"dark", "of the light", {0.4, 0.25, 0.15, 0.08, 0.04}, darken},
      {"brighter", "times", {1.25, 1.6, 2.0, 2.5, 4.0}, step_exposure},
      {"darker", "times", {0.8, 0.6, 0.4, 0.25, 0.15}, step_exposure},
      {"noise", "grey levels", {5.0, 10.0, 15.0, 20.0, 30.0}, add_noise},
      {"moving", "patches", {3.0, 6.0, 12.0, 20.0, 30.0}, add_moving},
  };
}

MatchScene spoiled(const MatchScene& scene,
                   const Condition& condition,
                   int severity,
                   const Random& random) {
  expects(severity >= 0 && severity <= static_cast<int>(kSeverities), "spoiled: severity 0 .. 5");
  MatchScene result = scene;
  if (severity > 0) {
    condition.spoil(result, condition.values.at(static_cast<std::size_t>(severity - 1)), random);
  }
  return result;
}

}  // namespace imslam::bench
