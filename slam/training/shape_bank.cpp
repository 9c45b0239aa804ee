#include "slam/training/shape_bank.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "slam/base/error.hpp"

namespace imslam::training {
namespace {

/// Positive inside; near the outline about the distance to it.
using Field = std::function<double(double s, double t)>;

Field blob(Random& random) {
  std::array<double, 5> amplitude{};
  std::array<double, 5> phase{};
  for (std::size_t k = 0; k < amplitude.size(); ++k) {
    amplitude[k] = random.uniform(0.0, 0.3) / static_cast<double>(k + 1);
    phase[k] = random.uniform(-M_PI, M_PI);
  }
  return [=](double s, double t) {
    const double angle = std::atan2(t, s);
    double radius = 0.65;
    for (std::size_t k = 0; k < amplitude.size(); ++k)
      radius += 0.65 * amplitude[k] * std::cos(static_cast<double>(k + 2) * angle + phase[k]);
    return radius - std::hypot(s, t);
  };
}

/// Corners at equal angles and random distances from the centre.
Field polygon(Random& random) {
  const auto corners = static_cast<std::size_t>(random.integer(3, 11));
  std::vector<double> radii(corners);
  for (double& radius : radii) radius = random.uniform(0.4, 0.97);
  return [radii](double s, double t) {
    const double sector = 2.0 * M_PI / static_cast<double>(radii.size());
    const double angle = std::atan2(t, s) + M_PI;
    const auto first = std::min(static_cast<std::size_t>(angle / sector), radii.size() - 1);
    const double a = radii[first];
    const double b = radii[(first + 1) % radii.size()];
    const double from = angle - static_cast<double>(first) * sector;
    // The side between corners a and b in polar coordinates.
    const double radius =
        a * b * std::sin(sector) / (a * std::sin(from) + b * std::sin(sector - from));
    return radius - std::hypot(s, t);
  };
}

Field box(Random& random) {
  const double corner = random.uniform(0.0, 0.4);
  const double half_t = random.uniform(0.5, 0.96);
  return [=](double s, double t) {
    const double x = std::max(std::abs(s) - 0.96 + corner, 0.0);
    const double y = std::max(std::abs(t) - half_t + corner, 0.0);
    const double inside = std::min(0.96 - std::abs(s), half_t - std::abs(t));
    return x > 0.0 && y > 0.0 ? corner - std::hypot(x, y) : inside;
  };
}

Field leaves(Random& random) {
  constexpr std::size_t kWaves = 14;
  std::array<std::array<double, 3>, kWaves> waves{};
  const double fineness = random.uniform(5.0, 14.0);
  for (auto& wave : waves) {
    const double angle = random.uniform(-M_PI, M_PI);
    const double frequency = fineness * random.uniform(0.6, 1.6);
    wave = {frequency * std::cos(angle), frequency * std::sin(angle), random.uniform(-M_PI, M_PI)};
  }
  const double level = random.uniform(-0.1, 0.15);
  const Field crown = blob(random);
  return [=](double s, double t) {
    double sum = 0.0;
    for (const auto& wave : waves) sum += std::cos(wave[0] * s + wave[1] * t + wave[2]);
    const double noise = (sum / std::sqrt(0.5 * kWaves) / 2.0 - level) / fineness;
    return std::min(noise, crown(s, t));
  };
}

Field fence(Random& random) {
  const double period = 2.0 / static_cast<double>(random.integer(3, 9));
  const double bar = random.uniform(0.25, 0.6) * period;
  const bool crossed = random.chance(0.4);
  return [=](double s, double t) {
    const auto to_bar = [&](double x) {
      return 0.5 * bar - std::abs(x - period * std::round(x / period));
    };
    const double bars = crossed ? std::max(to_bar(s), to_bar(t)) : to_bar(s);
    return std::min(bars, 0.97 - std::max(std::abs(s), std::abs(t)));
  };
}

Field pole(Random& random) {
  const double half = random.uniform(0.06, 0.2);
  return [=](double s, double t) { return std::min(half - std::abs(s), 0.97 - std::abs(t)); };
}

Field frame(Random& random) {
  const double width = random.uniform(0.12, 0.4);
  return [=](double s, double t) {
    const double reach = std::max(std::abs(s), std::abs(t));
    return std::min(0.96 - reach, reach - (0.96 - width));
  };
}

Field random_field(Random& random) {
  switch (random.integer(0, 9)) {
    case 0:
    case 1:
      return blob(random);
    case 2:
    case 3:
      return polygon(random);
    case 4:
    case 5:
      return box(random);
    case 6:
      return fence(random);
    case 7:
      return pole(random);
    case 8:
      return frame(random);
    default:
      return leaves(random);
  }
}

}  // namespace

ShapeBank::ShapeBank(std::size_t count, const Random& random) {
  expects(count > 0, "ShapeBank: at least one shape");
  samples_.reserve(count * kSize * kSize);
  for (std::size_t shape = 0; shape < count; ++shape) {
    Random own = random.fork(shape);
    const Field field = random_field(own);
    constexpr double kStep = 2.0 / (kSize - 1);
    constexpr double kGreyPerUnit = 16.0 / kStep;
    for (int row = 0; row < kSize; ++row) {
      for (int column = 0; column < kSize; ++column) {
        const double value = field(column * kStep - 1.0, row * kStep - 1.0);
        samples_.push_back(static_cast<std::uint8_t>(
            std::clamp(std::lround(double{kEdge} + kGreyPerUnit * value), 0L, 255L)));
      }
    }
  }
}

bool ShapeBank::inside(std::size_t shape, double s, double t) const {
  if (std::abs(s) >= 1.0 || std::abs(t) >= 1.0) return false;
  const double x = (0.5 * s + 0.5) * (kSize - 1);
  const double y = (0.5 * t + 0.5) * (kSize - 1);
  const int column = std::min(static_cast<int>(x), kSize - 2);
  const int row = std::min(static_cast<int>(y), kSize - 2);
  const double fx = x - column;
  const double fy = y - row;
  const std::uint8_t* at = samples(shape) + row * kSize + column;
  const double above = at[0] + fx * (at[1] - at[0]);
  const double below = at[kSize] + fx * (at[kSize + 1] - at[kSize]);
  return above + fy * (below - above) >= double{kEdge};
}

}  // namespace imslam::training
