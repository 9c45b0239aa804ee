#include "slam/training/match_sample.hpp"

#include <algorithm>
#include <cmath>

#include "slam/training/bounds.hpp"

namespace imslam::training {
namespace {

using nn::Index;
using nn::Tensor;

constexpr int kTextureTries = 4;
constexpr double kOneSurface = 0.5;  // [px] neighbours that differ more belong to different things

struct Place {
  double x = 0.0;
  double y = 0.0;
};

/// What is known about a place of left0.
struct PlaceTruth {
  double disparity = 0.0;
  double flow_u = 0.0;
  double flow_v = 0.0;
  MatchState disparity_state = MatchState::kNone;
  MatchState flow_state = MatchState::kNone;
};

Tensor<float> images_of(const Triplet& triplet) {
  Tensor<float> images({3, triplet.camera.height, triplet.camera.width, 1});
  float* next = images.data();
  for (const std::vector<float>* view : {&triplet.left0, &triplet.right0, &triplet.left1}) {
    next = std::copy(view->begin(), view->end(), next);
  }
  return images;
}

PlaceTruth at_pixel(const Triplet& triplet, std::size_t at) {
  return {static_cast<double>(triplet.disparity[at]), static_cast<double>(triplet.flow_u[at]),
          static_cast<double>(triplet.flow_v[at]), triplet.disparity_state[at],
          triplet.flow_state[at]};
}

double contrast(const Triplet& triplet, int row, int column) {
  const auto value = [&](int r, int c) {
    return static_cast<double>(triplet.left0[triplet.index(r, c)]);
  };
  return std::abs(value(row, column + 1) - value(row, column - 1)) +
         std::abs(value(row + 1, column) - value(row - 1, column));
}

Place draw_pixel(const Triplet& triplet, Random& random, bool textured) {
  Place best;
  double most = -1.0;
  for (int i = 0; i < (textured ? kTextureTries : 1); ++i) {
    const auto column = static_cast<int>(random.integer(1, triplet.camera.width - 2));
    const auto row = static_cast<int>(random.integer(1, triplet.camera.height - 2));
    const double here = textured ? contrast(triplet, row, column) : 0.0;
    if (here <= most) continue;
    most = here;
    best = {static_cast<double>(column), static_cast<double>(row)};
  }
  return best;
}

/// Moves the place by the fraction, if the pixels around show one surface that both views see.
PlaceTruth move_between_pixels(const Triplet& triplet, Place& place, double fx, double fy) {
  const auto column = static_cast<int>(place.x);
  const auto row = static_cast<int>(place.y);
  const PlaceTruth here = at_pixel(triplet, triplet.index(row, column));
  PlaceTruth mean;
  mean.disparity_state = mean.flow_state = MatchState::kVisible;
  for (const auto& [dy, dx] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}}) {
    const PlaceTruth near = at_pixel(triplet, triplet.index(row + dy, column + dx));
    const bool same = near.disparity_state == MatchState::kVisible &&
                      near.flow_state == MatchState::kVisible &&
                      std::abs(near.disparity - here.disparity) < kOneSurface &&
                      std::abs(near.flow_u - here.flow_u) < kOneSurface &&
                      std::abs(near.flow_v - here.flow_v) < kOneSurface;
    if (!same) return here;
    const double weight = (dx == 1 ? fx : 1.0 - fx) * (dy == 1 ? fy : 1.0 - fy);
    mean.disparity += weight * near.disparity;
    mean.flow_u += weight * near.flow_u;
    mean.flow_v += weight * near.flow_v;
  }
  place.x += fx;
  place.y += fy;
  return mean;
}

void put_truth(const PlaceTruth& truth, Index i, MatchSample& sample) {
  const bool flow_known = truth.flow_state != MatchState::kNone;
  const bool stereo_known = truth.disparity_state != MatchState::kNone;
  sample.flow.displacement[2 * i] = static_cast<float>(flow_known ? truth.flow_u : 0.0);
  sample.flow.displacement[2 * i + 1] = static_cast<float>(flow_known ? truth.flow_v : 0.0);
  sample.flow.valid[i] = flow_known ? 1.0F : 0.0F;
  sample.flow.visible[i] = truth.flow_state == MatchState::kVisible ? 1.0F : 0.0F;
  sample.stereo.displacement[i] = static_cast<float>(stereo_known ? -truth.disparity : 0.0);
  sample.stereo.valid[i] = stereo_known ? 1.0F : 0.0F;
  sample.stereo.visible[i] = truth.disparity_state == MatchState::kVisible ? 1.0F : 0.0F;
}

void put_guesses(const QueryOptions& options, Index i, Random& random, MatchSample& sample) {
  const double spread = options.most_guess_error / options.least_guess_error;
  const double sigma = options.least_guess_error * std::pow(spread, random.uniform());
  const auto near = [&](float truth) {
    return static_cast<float>(static_cast<double>(truth) + sigma * random.normal());
  };
  sample.flow_guess[2 * i] = near(sample.flow.displacement[2 * i]);
  sample.flow_guess[2 * i + 1] = near(sample.flow.displacement[2 * i + 1]);
  sample.stereo_guess[2 * i] = near(sample.stereo.displacement[i]);
  sample.stereo_guess[2 * i + 1] = 0.0F;
}

void draw_hint(const QueryOptions& options, Random& random, MatchSample& sample) {
  if (!random.chance(options.hint_share)) return;
  double sum_x = 0.0;
  double sum_y = 0.0;
  double count = 0.0;
  for (Index i = 0; i < sample.flow.visible.size(); ++i) {
    if (sample.flow.visible[i] == 0.0F) continue;
    sum_x += static_cast<double>(sample.flow.displacement[2 * i]);
    sum_y += static_cast<double>(sample.flow.displacement[2 * i + 1]);
    count += 1.0;
  }
  if (count == 0.0) return;
  sample.predicted_x = sum_x / count + options.hint_error * random.normal();
  sample.predicted_y = sum_y / count + options.hint_error * random.normal();
}

}  // namespace

void QueryOptions::describe(Config& config) {
  config.field("points", points, "query points per triplet");
  config.field("textured_share", textured_share, "points on texture");
  config.field("fractional_share", fractional_share, "points between pixels");
  config.field("hint_share", hint_share, "triplets whose search is told where to look");
  config.field("hint_error", hint_error, "sigma of what it is told [px]");
  config.field("least_guess_error", least_guess_error, "smallest sigma of teacher forcing [px]");
  config.field("most_guess_error", most_guess_error, "largest sigma of teacher forcing [px]");
}

void QueryOptions::validate() const {
  require_within("queries.points", points, 1, 100000);
  require_within("queries.textured_share", textured_share, 0.0, 1.0);
  require_within("queries.fractional_share", fractional_share, 0.0, 1.0);
  require_within("queries.hint_share", hint_share, 0.0, 1.0);
  require_within("queries.hint_error", hint_error, 0.0, 100.0);
  require_within("queries.least_guess_error", least_guess_error, 0.01, 100.0);
  require_within("queries.most_guess_error", most_guess_error, least_guess_error, 100.0);
}

MatchSample draw_queries(const Triplet& triplet, const QueryOptions& options, Random random) {
  const Index P = options.points;
  MatchSample sample;
  sample.images = images_of(triplet);
  sample.points = Tensor<float>({1, P, 2});
  sample.flow = {Tensor<float>({1, P, 2}), Tensor<float>({1, P}), Tensor<float>({1, P})};
  sample.stereo = {Tensor<float>({1, P, 1}), Tensor<float>({1, P}), Tensor<float>({1, P})};
  sample.flow_guess = Tensor<float>({1, P, 2});
  sample.stereo_guess = Tensor<float>({1, P, 2});
  for (Index i = 0; i < P; ++i) {
    Place place = draw_pixel(triplet, random, random.chance(options.textured_share));
    const bool fractional = random.chance(options.fractional_share);
    const double fx = fractional ? random.uniform() : 0.0;
    const double fy = fractional ? random.uniform() : 0.0;
    put_truth(move_between_pixels(triplet, place, fx, fy), i, sample);
    sample.points[2 * i] = static_cast<float>(place.x);
    sample.points[2 * i + 1] = static_cast<float>(place.y);
    put_guesses(options, i, random, sample);
  }
  draw_hint(options, random, sample);
  return sample;
}

vo::NetworkMatch match_sample(nn::Tape<float>& tape,
                              vo::MatchNetwork<float>& network,
                              const vo::FeaturePyramid& features,
                              const MatchSample& sample,
                              vo::MatchKind kind,
                              bool teacher) {
  const bool flow = kind == vo::MatchKind::kFlow;
  vo::MatchHint hint;
  if (flow) {
    hint.predicted_x = sample.predicted_x;
    hint.predicted_y = sample.predicted_y;
  }
  if (teacher) hint.guess = tape.constant(flow ? sample.flow_guess : sample.stereo_guess);
  return network.forward(tape, sample_of(tape, features, 0),
                         sample_of(tape, features, flow ? 2 : 1), tape.constant(sample.points),
                         kind, hint);
}

}  // namespace imslam::training
