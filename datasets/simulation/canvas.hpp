#pragma once

#include <opencv2/core.hpp>

#include "datasets/simulation/texture.hpp"
#include "slam/base/random.hpp"

namespace imslam::simulation {

/// A square grey drawing that repeats without seams; values around [0, 1]. The brush of the
/// procedural materials.
///
/// Lengths are pixels of the tile; `contrast` is the sigma or half range of what is added.
class Canvas {
 public:
  Canvas(int size, double value);

  void fill(double value);

  /// Fractal noise: `across` x `down` lattice cells in the first octave, doubled in every further
  /// one while the amplitude is multiplied by `gain`.
  void add_noise(Random& random, int across, int down, int octaves, double gain, double contrast);

  /// Rows of blocks with joints of the present colour; each block has its own brightness.
  void bricks(Random& random,
              int columns,
              int rows,
              int joint,
              double value,
              double contrast,
              bool staggered = true);

  /// Crooked lines; `bend` is the change of direction per step, `angle` the preferred direction.
  void scatter_strokes(Random& random,
                       int count,
                       double thickness,
                       double length,
                       double bend,
                       double contrast,
                       double angle = 0.0,
                       double angle_spread = 3.2);
  void scatter_spots(Random& random, int count, double smallest, double largest, double contrast);
  void scatter_leaves(Random& random, int count, double smallest, double largest, double contrast);
  void scatter_polygons(
      Random& random, int count, double smallest, double largest, double contrast);

  void text_lines(Random& random, int lines);
  void book_rows(Random& random, int rows);
  void panels(Random& random, int columns, int rows);
  void windows(Random& random, int columns, int rows);
  void stripes(Random& random, int count, double contrast);

  Texture texture() const;

 private:
  template <typename Draw>
  void wrapped(double x, double y, double reach, const Draw& draw);
  double shade_at(double x, double y, double change) const;

  int size_;
  cv::Mat1b image_;
};

}  // namespace imslam::simulation
