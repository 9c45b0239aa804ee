#include "datasets/simulation/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace imslam::simulation {
namespace {

constexpr int kShift = 4;  ///< OpenCV draws with fractional coordinates of 1/16 pixel

int fixed(double x) { return static_cast<int>(std::lround(x * (1 << kShift))); }
cv::Point fixed(double x, double y) { return {fixed(x), fixed(y)}; }
cv::Scalar grey(double value) { return cv::Scalar(std::clamp(value, 0.0, 1.0) * 255.0); }

/// Smooth noise of unit variance: a random lattice, enlarged cubically, without a seam.
cv::Mat1f lattice_noise(Random& random, int across, int down, int size) {
  cv::Mat1f lattice(down, across);
  for (float& value : lattice) value = static_cast<float>(random.normal());
  constexpr int kPad = 4;
  cv::Mat1f padded;
  cv::copyMakeBorder(lattice, padded, kPad, kPad, kPad, kPad, cv::BORDER_WRAP);
  const double fx = static_cast<double>(size) / across;
  const double fy = static_cast<double>(size) / down;
  const cv::Size full(static_cast<int>(std::lround(padded.cols * fx)),
                      static_cast<int>(std::lround(padded.rows * fy)));
  cv::Mat1f enlarged;
  cv::resize(padded, enlarged, full, 0, 0, cv::INTER_CUBIC);
  const cv::Rect middle(static_cast<int>(std::lround(kPad * fx)),
                        static_cast<int>(std::lround(kPad * fy)), size, size);
  return enlarged(middle).clone();
}

}  // namespace

Canvas::Canvas(int size, double value) : size_(size), image_(size, size) { fill(value); }

void Canvas::fill(double value) { image_.setTo(grey(value)); }

/// Draws at (x, y) and at those of the 8 copies one tile away that reach into the tile.
template <typename Draw>
void Canvas::wrapped(double x, double y, double reach, const Draw& draw) {
  const auto shifts = [&](double c) {
    std::vector<double> result = {0.0};
    if (c < reach) result.push_back(size_);
    if (c > size_ - reach) result.push_back(-size_);
    return result;
  };
  for (const double dy : shifts(y)) {
    for (const double dx : shifts(x)) draw(x + dx, y + dy);
  }
}

double Canvas::shade_at(double x, double y, double change) const {
  const int column = std::clamp(static_cast<int>(x), 0, size_ - 1);
  const int row = std::clamp(static_cast<int>(y), 0, size_ - 1);
  return image_(row, column) / 255.0 + change;
}

void Canvas::add_noise(
    Random& random, int across, int down, int octaves, double gain, double contrast) {
  cv::Mat1f sum(size_, size_, 0.0F);
  double amplitude = 1.0;
  double power = 0.0;
  for (int octave = 0; octave < octaves; ++octave) {
    const int columns = std::min(across << octave, size_);
    const int rows = std::min(down << octave, size_);
    sum += amplitude * lattice_noise(random, columns, rows, size_);
    power += amplitude * amplitude;
    amplitude *= gain;
  }
  cv::Mat1f result;
  image_.convertTo(result, CV_32F);
  // Half of the contrast is proportional: dark surfaces keep their darkness.
  const double scale = contrast / std::sqrt(power);
  const cv::Mat1f factor(0.5 * scale * sum + 1.0);
  result = result.mul(factor) + 0.5 * 0.45 * 255.0 * scale * sum;
  result.convertTo(image_, CV_8U);
}

void Canvas::bricks(Random& random,
                    int columns,
                    int rows,
                    int joint,
                    double value,
                    double contrast,
                    bool staggered) {
  const double width = static_cast<double>(size_) / columns;
  const double height = static_cast<double>(size_) / rows;
  for (int row = 0; row < rows; ++row) {
    const double offset = staggered ? random.uniform(0.3, 0.7) * width * (row % 2) : 0.0;
    for (int column = 0; column < columns; ++column) {
      const cv::Scalar colour = grey(value + contrast * random.normal());
      const double half = 0.5 * joint;
      wrapped(column * width + offset, row * height, width, [&](double x, double y) {
        cv::rectangle(image_, fixed(x + half, y + half),
                      fixed(x + width - half - 1, y + height - half - 1), colour, cv::FILLED,
                      cv::LINE_AA, kShift);
      });
    }
  }
}

void Canvas::scatter_strokes(Random& random,
                             int count,
                             double thickness,
                             double length,
                             double bend,
                             double contrast,
                             double angle,
                             double angle_spread) {
  constexpr int kSteps = 5;
  for (int i = 0; i < count; ++i) {
    const double x0 = random.uniform(0, size_);
    const double y0 = random.uniform(0, size_);
    double direction = angle + random.uniform(-0.5, 0.5) * angle_spread;
    const double step = length * random.uniform(0.3, 1.0) / kSteps;
    std::vector<cv::Point2d> points = {{0.0, 0.0}};
    for (int k = 0; k < kSteps; ++k) {
      direction += bend * random.normal();
      points.push_back(points.back() +
                       step * cv::Point2d(std::cos(direction), std::sin(direction)));
    }
    const cv::Scalar colour = grey(shade_at(x0, y0, contrast * random.normal()));
    const int width =
        std::max(1, static_cast<int>(std::lround(thickness * random.uniform(0.5, 1.5))));
    wrapped(x0, y0, length + width, [&](double x, double y) {
      for (std::size_t k = 1; k < points.size(); ++k) {
        cv::line(image_, fixed(x + points[k - 1].x, y + points[k - 1].y),
                 fixed(x + points[k].x, y + points[k].y), colour, width, cv::LINE_AA, kShift);
      }
    });
  }
}

void Canvas::scatter_spots(
    Random& random, int count, double smallest, double largest, double contrast) {
  for (int i = 0; i < count; ++i) {
    const double x0 = random.uniform(0, size_);
    const double y0 = random.uniform(0, size_);
    const double radius = smallest + (largest - smallest) * std::pow(random.uniform(), 2.0);
    const cv::Scalar colour = grey(shade_at(x0, y0, contrast * random.normal()));
    wrapped(x0, y0, radius + 1, [&](double x, double y) {
      cv::circle(image_, fixed(x, y), fixed(radius), colour, cv::FILLED, cv::LINE_AA, kShift);
    });
  }
}

void Canvas::scatter_leaves(
    Random& random, int count, double smallest, double largest, double contrast) {
  for (int i = 0; i < count; ++i) {
    const double x0 = random.uniform(0, size_);
    const double y0 = random.uniform(0, size_);
    const double length = random.uniform(smallest, largest);
    const double turn = random.uniform(0, 360);
    const double slim = random.uniform(0.25, 0.6);
    const double shade = shade_at(x0, y0, contrast * random.normal());
    wrapped(x0, y0, length + 2, [&](double x, double y) {
      cv::ellipse(image_, fixed(x, y), cv::Size(fixed(length), fixed(slim * length)), turn, 0, 360,
                  grey(shade), cv::FILLED, cv::LINE_AA, kShift);
      const double dx = length * std::cos(turn * M_PI / 180.0);
      const double dy = length * std::sin(turn * M_PI / 180.0);
      cv::line(image_, fixed(x - dx, y - dy), fixed(x + dx, y + dy), grey(shade - 0.12), 1,
               cv::LINE_AA, kShift);  // midrib
    });
  }
}

void Canvas::scatter_polygons(
    Random& random, int count, double smallest, double largest, double contrast) {
  for (int i = 0; i < count; ++i) {
    const double x0 = random.uniform(0, size_);
    const double y0 = random.uniform(0, size_);
    const double radius = random.uniform(smallest, largest);
    const auto corners = random.integer(3, 8);
    const double turn = random.uniform(0, 2 * M_PI);
    std::vector<cv::Point2d> shape;
    for (int k = 0; k < corners; ++k) {
      const double angle = turn + 2 * M_PI * k / static_cast<double>(corners);
      const double reach = radius * random.uniform(0.6, 1.0);
      shape.emplace_back(reach * std::cos(angle), reach * std::sin(angle));
    }
    const cv::Scalar colour = grey(shade_at(x0, y0, contrast * random.normal()));
    wrapped(x0, y0, radius + 1, [&](double x, double y) {
      std::vector<cv::Point> points;
      for (const cv::Point2d& corner : shape) points.push_back(fixed(x + corner.x, y + corner.y));
      cv::fillConvexPoly(image_, points, colour, cv::LINE_AA, kShift);
    });
  }
}

void Canvas::text_lines(Random& random, int lines) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPRSTUVWXYZ abcdefghiklmnoprstu 0123456789-";
  for (int i = 0; i < lines; ++i) {
    std::string text;
    const auto letters = random.integer(4, 22);
    for (int k = 0; k < letters; ++k) {
      text += alphabet[static_cast<std::size_t>(
          random.integer(0, static_cast<std::int64_t>(alphabet.size()) - 1))];
    }
    const double scale = random.uniform(0.5, 2.2);
    const double x = random.uniform(0.03, 0.4) * size_;
    const double y = random.uniform(0.08, 0.98) * size_;
    const cv::Point origin(static_cast<int>(x), static_cast<int>(y));
    const double shade = random.chance(0.6) ? random.uniform(0.0, 0.2) : random.uniform(0.8, 1.0);
    cv::putText(image_, text, origin, cv::FONT_HERSHEY_DUPLEX, scale, grey(shade),
                std::max(1, static_cast<int>(scale * 1.6)), cv::LINE_AA);
  }
}

void Canvas::book_rows(Random& random, int rows) {
  const double height = static_cast<double>(size_) / rows;
  for (int row = 0; row < rows; ++row) {
    const double bottom = (row + 1) * height - 0.07 * height;
    for (double x = 2.0; x < size_ - 4.0;) {
      const double width = random.uniform(0.02, 0.065) * size_;
      const double top = bottom - height * random.uniform(0.6, 0.88);
      const double shade = random.uniform(0.1, 0.9);
      if (random.chance(0.93)) {
        cv::rectangle(image_, fixed(x, top), fixed(x + width - 2, bottom), grey(shade), cv::FILLED,
                      cv::LINE_AA, kShift);
        const double band = random.uniform(0.15, 0.8);
        const double y = top + band * (bottom - top);
        cv::rectangle(image_, fixed(x + 1, y), fixed(x + width - 3, y + 0.1 * height),
                      grey(shade > 0.5 ? shade - 0.4 : shade + 0.4), cv::FILLED, cv::LINE_AA,
                      kShift);
      }
      x += width;
    }
    cv::rectangle(image_, cv::Point(0, static_cast<int>(bottom)),
                  cv::Point(size_, static_cast<int>((row + 1) * height)), grey(0.5), cv::FILLED);
  }
}

void Canvas::panels(Random& random, int columns, int rows) {
  const double width = static_cast<double>(size_) / columns;
  const double height = static_cast<double>(size_) / rows;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double margin = random.uniform(0.08, 0.13) * std::min(width, height);
      const double x0 = column * width + margin;
      const double y0 = row * height + margin;
      const double x1 = (column + 1) * width - margin;
      const double y1 = (row + 1) * height - margin;
      const double shade = shade_at(x0, y0, 0.0);
      cv::line(image_, fixed(x0, y0), fixed(x1, y0), grey(shade - 0.25), 3, cv::LINE_AA, kShift);
      cv::line(image_, fixed(x0, y0), fixed(x0, y1), grey(shade - 0.2), 3, cv::LINE_AA, kShift);
      cv::line(image_, fixed(x1, y0), fixed(x1, y1), grey(shade + 0.2), 3, cv::LINE_AA, kShift);
      cv::line(image_, fixed(x0, y1), fixed(x1, y1), grey(shade + 0.25), 3, cv::LINE_AA, kShift);
    }
  }
}

void Canvas::windows(Random& random, int columns, int rows) {
  const double width = static_cast<double>(size_) / columns;
  const double height = static_cast<double>(size_) / rows;
  const double wide = random.uniform(0.4, 0.65);
  const double tall = random.uniform(0.5, 0.7);
  const double frame = random.uniform(0.7, 0.95);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double x0 = (column + 0.5 - 0.5 * wide) * width;
      const double y0 = (row + 0.5 - 0.5 * tall) * height;
      const double x1 = x0 + wide * width;
      const double y1 = y0 + tall * height;
      cv::rectangle(image_, fixed(x0 - 5, y0 - 5), fixed(x1 + 5, y1 + 5), grey(frame), cv::FILLED,
                    cv::LINE_AA, kShift);
      cv::rectangle(image_, fixed(x0, y0), fixed(x1, y1), grey(random.uniform(0.05, 0.3)),
                    cv::FILLED, cv::LINE_AA, kShift);
      const double curtain = random.uniform(0.0, 0.6) * (x1 - x0);
      cv::rectangle(image_, fixed(x0, y0), fixed(x0 + curtain, y1), grey(random.uniform(0.3, 0.8)),
                    cv::FILLED, cv::LINE_AA, kShift);
      const double middle = 0.5 * (x0 + x1);
      cv::line(image_, fixed(middle, y0), fixed(middle, y1), grey(frame), 5, cv::LINE_AA, kShift);
      cv::line(image_, fixed(x0, y0 + 0.35 * (y1 - y0)), fixed(x1, y0 + 0.35 * (y1 - y0)),
               grey(frame), 4, cv::LINE_AA, kShift);
      cv::rectangle(image_, fixed(x0 - 9, y1 + 6), fixed(x1 + 9, y1 + 13), grey(frame - 0.25),
                    cv::FILLED, cv::LINE_AA, kShift);  // sill
    }
  }
}

void Canvas::stripes(Random& random, int count, double contrast) {
  const double width = static_cast<double>(size_) / count;
  for (int i = 0; i < count; ++i) {
    const double x = i * width;
    const cv::Scalar colour = grey(shade_at(x, 0, contrast * random.normal()));
    cv::rectangle(image_, fixed(x, 0.0), fixed(x + width * random.uniform(0.3, 0.8), size_), colour,
                  cv::FILLED, cv::LINE_AA, kShift);
  }
}

Texture Canvas::texture() const {
  return Texture(size_, std::vector<std::uint8_t>(image_.begin(), image_.end()));
}

}  // namespace imslam::simulation
