#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "slam/nn/training/data_parallel.hpp"
#include "slam/nn/training/gradients.hpp"
#include "slam/nn/training/optimizer.hpp"
#include "slam/nn/training/schedule.hpp"
#include "tests/vo_net/match_fixture.hpp"

namespace imslam::testing {

/// One pair to learn from.
struct MatchSample {
  static constexpr nn::Index kHeight = 96;
  static constexpr nn::Index kWidth = 112;
  static constexpr nn::Index kPoints = 60;

  vo::MatchKind kind;
  TexturedPair pair;
  nn::Tensor<double> points;
  vo::MatchTruth<double> truth;

  MatchSample(vo::MatchKind what, std::uint64_t seed, DisplacementField field)
      : kind(what), pair(seed, kHeight, kWidth, std::move(field)) {
    Random random(seed + 100);
    points = random_points(random, kPoints, kHeight, kWidth, 20.0);
    truth = truth_at(pair, points, kind);
  }
};

/// `samples(step)` is the batch of a step.
inline void train(vo::MatchNetwork<float>& network,
                  const std::function<std::vector<MatchSample>(int step)>& samples,
                  int steps) {
  const nn::ParameterList<float> parameters = parameters_of(network);
  nn::DataParallel<float> batch(parameters, 2);
  nn::Adam<float> optimizer;
  nn::Gradients<float> gradients = nn::zero_gradients(parameters);
  const nn::CosineSchedule schedule{6e-3, steps, std::min(steps, 10)};
  for (int step = 0; step < steps; ++step) {
    const std::vector<MatchSample> chosen = samples(step);
    batch.run(
        chosen.size(),
        [&](nn::Tape<float>& tape, std::size_t i) {
          const MatchSample& s = chosen[i];
          const vo::NetworkMatch match = match_pair(tape, network, s.pair, s.points, s.kind);
          return match_loss(tape, match, cast_truth<float>(s.truth)).total;
        },
        gradients);
    nn::clip_network_norms(parameters, gradients, 5.0);
    optimizer.step(parameters, gradients, schedule.rate(step));
  }
}

/// A tiny network that knows shifts of random textures, folded. Takes a few seconds.
inline vo::MatchNetwork<float> trained_match_network() {
  Random random(31);
  vo::MatchNetwork<float> network(tiny_match_network(), random);
  const auto shifts = [&](int step) {
    const Displacement flow{random.uniform(-12.0, 12.0), random.uniform(-12.0, 12.0)};
    const Displacement stereo{random.uniform(-20.0, -2.0), 0.0};
    const auto seed = static_cast<std::uint64_t>(1000 + step);
    std::vector<MatchSample> samples;
    samples.emplace_back(vo::MatchKind::kFlow, seed, [=](double, double) { return flow; });
    samples.emplace_back(vo::MatchKind::kStereo, seed, [=](double, double) { return stereo; });
    return samples;
  };
  train(network, shifts, 300);
  network.fold();
  return network;
}

}  // namespace imslam::testing
