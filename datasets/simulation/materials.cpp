#include "datasets/simulation/materials.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "datasets/simulation/canvas.hpp"

namespace imslam::simulation {
namespace {

constexpr int kSize = 512;

Canvas plaster(Random& random) {
  Canvas canvas(kSize, random.uniform(0.5, 0.8));
  canvas.add_noise(random, 4, 4, 7, 0.62, 0.22);
  canvas.scatter_strokes(random, 60, 0.5, 6.0, 0.02, 0.16);  // scratches
  canvas.scatter_spots(random, 90, 0.8, 3.5, 0.25);          // dirt, nail holes
  return canvas;
}

Canvas brick(Random& random) {
  Canvas canvas(kSize, random.uniform(0.55, 0.7));
  canvas.bricks(random, 8, 16, 4, random.uniform(0.25, 0.5), 0.22);
  canvas.add_noise(random, 16, 16, 5, 0.7, 0.2);
  return canvas;
}

Canvas planks(Random& random) {
  Canvas canvas(kSize, 0.15);
  canvas.bricks(random, 3, 8, 2, random.uniform(0.4, 0.6), 0.15);
  canvas.add_noise(random, 4, 64, 4, 0.65, 0.3);  // grain along the boards
  canvas.scatter_spots(random, 26, 2.0, 6.0, 0.35);
  return canvas;
}

Canvas tiles(Random& random) {
  Canvas canvas(kSize, random.uniform(0.25, 0.4));
  canvas.bricks(random, 5, 5, 4, random.uniform(0.5, 0.7), 0.14, false);
  canvas.add_noise(random, 8, 8, 6, 0.7, 0.22);
  canvas.scatter_spots(random, 120, 0.8, 2.5, 0.3);
  return canvas;
}

Canvas carpet(Random& random) {
  Canvas canvas(kSize, random.uniform(0.3, 0.5));
  const int motifs = static_cast<int>(random.integer(20, 50));
  canvas.scatter_polygons(random, motifs, 10.0, 42.0, 0.3);
  canvas.add_noise(random, 6, 6, 4, 0.6, 0.15);
  canvas.add_noise(random, 128, 128, 2, 0.8, 0.2);
  return canvas;
}

Canvas concrete(Random& random) {
  Canvas canvas(kSize, random.uniform(0.45, 0.65));
  canvas.add_noise(random, 3, 3, 8, 0.68, 0.35);
  canvas.scatter_spots(random, 220, 0.8, 3.0, 0.3);
  canvas.scatter_strokes(random, 12, 0.7, 50.0, 0.6, 0.3);  // cracks
  return canvas;
}

Canvas asphalt(Random& random) {
  Canvas canvas(kSize, random.uniform(0.28, 0.38));
  canvas.add_noise(random, 3, 3, 4, 0.6, 0.22);
  canvas.scatter_spots(random, 2600, 0.7, 2.4, 0.3);
  canvas.scatter_polygons(random, 4, 30.0, 80.0, 0.07);      // patches
  canvas.scatter_strokes(random, 14, 1.0, 80.0, 0.8, 0.22);  // cracks
  return canvas;
}

Canvas bark(Random& random) {
  Canvas canvas(kSize, random.uniform(0.3, 0.45));
  canvas.add_noise(random, 24, 4, 5, 0.7, 0.55);
  canvas.scatter_strokes(random, 170, 1.6, 40.0, 0.1, 0.3, M_PI / 2);
  canvas.scatter_spots(random, 60, 2.0, 8.0, 0.2);
  return canvas;
}

Canvas ground(Random& random) {
  Canvas canvas(kSize, random.uniform(0.3, 0.42));
  canvas.add_noise(random, 4, 4, 6, 0.7, 0.35);
  canvas.scatter_leaves(random, 700, 3.0, 12.0, 0.3);
  canvas.scatter_strokes(random, 60, 1.4, 45.0, 0.4, 0.3);  // twigs
  return canvas;
}

Canvas grass(Random& random) {
  Canvas canvas(kSize, random.uniform(0.3, 0.4));
  canvas.add_noise(random, 5, 5, 4, 0.6, 0.3);
  canvas.scatter_strokes(random, 3000, 1.2, 16.0, 0.3, 0.24, M_PI / 2, 0.6);
  return canvas;
}

Canvas leaf(Random& random) {
  Canvas canvas(kSize, random.uniform(0.35, 0.5));
  canvas.add_noise(random, 8, 8, 5, 0.6, 0.3);
  canvas.scatter_leaves(random, 900, 6.0, 26.0, 0.32);
  return canvas;
}

Canvas rock(Random& random) {
  Canvas canvas(kSize, random.uniform(0.4, 0.55));
  canvas.add_noise(random, 4, 4, 8, 0.75, 0.55);
  canvas.scatter_strokes(random, 40, 1.2, 60.0, 0.9, 0.3);
  canvas.scatter_spots(random, 300, 1.0, 5.0, 0.25);
  return canvas;
}

Canvas facade(Random& random) {
  Canvas canvas(kSize, 0.45);
  if (random.chance(0.6)) {
    canvas.bricks(random, 48, 32, 1, random.uniform(0.4, 0.6), 0.15);
  } else {
    canvas.fill(random.uniform(0.45, 0.75));
  }
  canvas.add_noise(random, 3, 3, 7, 0.7, 0.25);
  const int columns = static_cast<int>(random.integer(2, 4));
  const int rows = static_cast<int>(random.integer(2, 3));
  canvas.windows(random, columns, rows);
  return canvas;
}

Canvas poster(Random& random) {
  Canvas canvas(kSize, random.uniform(0.3, 0.85));
  canvas.add_noise(random, 2, 2, 4, 0.5, 0.45);
  canvas.scatter_polygons(random, static_cast<int>(random.integer(8, 30)), 15.0, 110.0, 0.4);
  canvas.text_lines(random, static_cast<int>(random.integer(3, 14)));
  canvas.add_noise(random, 64, 64, 3, 0.7, 0.06);
  return canvas;
}

Canvas books(Random& random) {
  Canvas canvas(kSize, 0.08);
  canvas.book_rows(random, 3);
  canvas.add_noise(random, 32, 32, 3, 0.7, 0.08);
  return canvas;
}

Canvas door(Random& random) {
  Canvas canvas(kSize, random.uniform(0.3, 0.6));
  canvas.add_noise(random, 40, 3, 5, 0.65, 0.28);
  canvas.panels(random, 2, 3);
  canvas.text_lines(random, 1);
  return canvas;
}

Canvas ceiling(Random& random) {
  Canvas canvas(kSize, 0.3);
  canvas.bricks(random, 4, 4, 3, random.uniform(0.6, 0.75), 0.05, false);
  canvas.scatter_spots(random, 900, 0.8, 2.2, 0.35);
  canvas.add_noise(random, 4, 4, 5, 0.6, 0.08);
  return canvas;
}

Canvas fabric(Random& random) {
  Canvas canvas(kSize, random.uniform(0.3, 0.6));
  canvas.stripes(random, static_cast<int>(random.integer(3, 9)), 0.18);
  canvas.add_noise(random, 64, 128, 2, 0.8, 0.22);
  canvas.add_noise(random, 3, 3, 4, 0.6, 0.22);
  return canvas;
}

Canvas metal(Random& random) {
  Canvas canvas(kSize, random.uniform(0.4, 0.65));
  canvas.add_noise(random, 3, 100, 4, 0.7, 0.18);
  canvas.panels(random, 2, 2);
  canvas.scatter_spots(random, 60, 1.5, 4.0, 0.35);
  canvas.text_lines(random, 2);
  return canvas;
}

Canvas car(Random& random) {
  Canvas canvas(kSize, random.uniform(0.2, 0.85));
  canvas.add_noise(random, 2, 2, 6, 0.6, 0.16);
  canvas.panels(random, 2, 1);
  canvas.scatter_spots(random, 50, 1.0, 4.0, 0.2);
  return canvas;
}

Canvas glass(Random& random) {
  Canvas canvas(kSize, random.uniform(0.1, 0.2));
  canvas.add_noise(random, 2, 3, 5, 0.6, 0.3);  // reflections
  canvas.scatter_polygons(random, 5, 30.0, 110.0, 0.12);
  canvas.panels(random, 1, 1);
  return canvas;
}

Canvas sign(Random& random) {
  Canvas canvas(kSize, random.uniform(0.5, 0.9));
  canvas.panels(random, 1, 1);
  canvas.scatter_polygons(random, 3, 40.0, 120.0, 0.45);
  canvas.text_lines(random, 4);
  return canvas;
}

Canvas sky(Random& random) {
  Canvas canvas(kSize, random.uniform(0.75, 0.85));
  canvas.add_noise(random, 3, 3, 6, 0.55, 0.35);
  return canvas;
}

Canvas canvas_of(Material material, Random& random) {
  switch (material) {
    case Material::kPlaster:
      return plaster(random);
    case Material::kBrick:
      return brick(random);
    case Material::kPlanks:
      return planks(random);
    case Material::kTiles:
      return tiles(random);
    case Material::kCarpet:
      return carpet(random);
    case Material::kConcrete:
      return concrete(random);
    case Material::kAsphalt:
      return asphalt(random);
    case Material::kBark:
      return bark(random);
    case Material::kGround:
      return ground(random);
    case Material::kGrass:
      return grass(random);
    case Material::kLeaf:
      return leaf(random);
    case Material::kRock:
      return rock(random);
    case Material::kFacade:
      return facade(random);
    case Material::kPoster:
      return poster(random);
    case Material::kBooks:
      return books(random);
    case Material::kDoor:
      return door(random);
    case Material::kCeiling:
      return ceiling(random);
    case Material::kFabric:
      return fabric(random);
    case Material::kMetal:
      return metal(random);
    case Material::kCar:
      return car(random);
    case Material::kGlass:
      return glass(random);
    case Material::kSign:
      return sign(random);
    case Material::kSky:
      return sky(random);
  }
  return plaster(random);
}

}  // namespace

Texture draw_material(Material material, Random random) {
  return canvas_of(material, random).texture();
}

}  // namespace imslam::simulation
