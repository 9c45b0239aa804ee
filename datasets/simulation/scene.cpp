#include "datasets/simulation/scene.hpp"

#include "datasets/simulation/motion.hpp"
#include "slam/base/error.hpp"

namespace imslam::simulation {

Paint Scene::paint(TextureBank& bank, Material material, double tile_m, Random& random) {
  textures.push_back(bank.make(material, random.fork(textures.size())));
  const double u = random.uniform();
  const double v = random.uniform();
  Paint result;
  result.texture = static_cast<std::uint32_t>(textures.size() - 1);
  result.tile_m = static_cast<float>(tile_m);
  if (tile_m > 0.0) result.offset = Eigen::Vector2d(u, v).cast<float>();
  return result;
}

Scene make_scene(const SimulationOptions& options, TextureBank& bank, const Random& random) {
  if (options.scene == "corridor") return make_corridor(bank, random);
  if (options.scene == "forest") return make_forest(bank, random);
  if (options.scene == "street") {
    std::function<double(double)> clock;
    if (options.dynamic_objects) {
      clock = [options](double t) {
        return options.motion == "natural" ? travel_time(options, t) : 0.0;
      };
    }
    return make_street(bank, random, clock);
  }
  expects(options.scene == "room", "make_scene: unknown scene");
  return make_room(bank, random);
}

}  // namespace imslam::simulation
