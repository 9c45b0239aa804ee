#include "datasets/simulation/texture_bank.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"

namespace imslam::simulation {
namespace {

constexpr int kTile = 512;
constexpr double kDrawnShare = 0.6;
constexpr double kLively = 8.0;                  ///< mean of the absolute Laplacian [grey levels]
constexpr std::uintmax_t kSmallestFile = 30000;  // smaller pictures are icons and plain colours

std::vector<std::filesystem::path> pictures_in(const std::vector<std::string>& folders) {
  std::vector<std::filesystem::path> files;
  for (const std::string& folder : folders) {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, ignored)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".jpg" && extension != ".png" && extension != ".jpeg") continue;
      if (!entry.is_regular_file(ignored) || entry.is_symlink(ignored)) continue;
      if (entry.file_size(ignored) >= kSmallestFile) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());  // folder order depends on the file system
  return files;
}

/// A square piece of the photograph at a random place and scale, of side `size`.
cv::Mat1b random_piece(const cv::Mat1b& photo, int size, Random& random) {
  const int shorter = std::min(photo.cols, photo.rows);
  const double largest = shorter;
  const double smallest = std::min<double>(largest, 0.75 * size);
  const int side = static_cast<int>(random.uniform(smallest, largest));
  const int x = static_cast<int>(random.integer(0, photo.cols - side));
  const int y = static_cast<int>(random.integer(0, photo.rows - side));
  cv::Mat1b crop;
  cv::resize(photo(cv::Rect(x, y, side, side)), crop, cv::Size(size, size), 0, 0,
             side > size ? cv::INTER_AREA : cv::INTER_CUBIC);
  return crop;
}

/// A piece with something to see in it: wallpapers have large empty places.
cv::Mat1b lively_piece(const cv::Mat1b& photo, int size, Random& random) {
  constexpr int kTries = 8;
  cv::Mat1b best;
  double most = -1.0;
  for (int i = 0; i < kTries && most < kLively; ++i) {
    const cv::Mat1b piece = random_piece(photo, size, random);
    cv::Mat1f edges;
    cv::Laplacian(piece, edges, CV_32F);
    const double detail = cv::norm(edges, cv::NORM_L1) / static_cast<double>(edges.total());
    if (detail > most) {
      most = detail;
      best = piece;
    }
  }
  return best;
}

/// A tile without seams: the piece beside its mirror images.
cv::Mat1b mirrored(const cv::Mat1b& piece) {
  cv::Mat1b right;
  cv::Mat1b top;
  cv::Mat1b tile;
  cv::Mat1b bottom;
  cv::flip(piece, right, 1);
  cv::hconcat(piece, right, top);
  cv::flip(top, bottom, 0);
  cv::vconcat(top, bottom, tile);
  return tile;
}

/// Takes away slow changes of brightness, keeps the detail, and gives a chosen mean.
cv::Mat1b detail_only(const cv::Mat1b& piece, double mean, double gain) {
  cv::Mat1f image;
  piece.convertTo(image, CV_32F);
  cv::Mat1f slow;
  cv::GaussianBlur(image, slow, cv::Size(), 0.12 * piece.cols, 0, cv::BORDER_REFLECT);
  cv::Mat1b result;
  cv::Mat1f(gain * (image - 0.8 * slow) + (mean - 0.2 * gain * cv::mean(slow)[0]))
      .convertTo(result, CV_8U);
  return result;
}

bool wants_whole_picture(Material material) {
  return material == Material::kPoster || material == Material::kSign;
}

bool lies_on_the_ground(Material material) {
  switch (material) {
    case Material::kGround:
    case Material::kGrass:
    case Material::kRock:
    case Material::kConcrete:
    case Material::kAsphalt:
      return true;
    default:
      return false;
  }
}

/// Pictures carry structure of their own (windows, books, boards) only where drawn ones have none.
bool may_be_photo(Material material) {
  switch (material) {
    case Material::kFacade:
    case Material::kBooks:
    case Material::kDoor:
    case Material::kSky:
    case Material::kGlass:
    case Material::kTiles:
    case Material::kCeiling:
      return false;
    default:
      return true;
  }
}

/// Adds the drawn material's detail: what photographs lack from near.
void add_detail(cv::Mat1b& tile, const Texture& drawn, double mean) {
  const int mask = drawn.size() - 1;
  for (int y = 0; y < tile.rows; ++y) {
    for (int x = 0; x < tile.cols; ++x) {
      const double detail = drawn.pixels()[(y & mask) * drawn.size() + (x & mask)] - mean;
      tile(y, x) = cv::saturate_cast<std::uint8_t>(tile(y, x) + kDrawnShare * detail);
    }
  }
}

Texture to_texture(const cv::Mat1b& tile) {
  const cv::Mat1b whole = tile.isContinuous() ? tile : tile.clone();
  return Texture(whole.cols, std::vector<std::uint8_t>(whole.begin(), whole.end()));
}

}  // namespace

TextureBank::TextureBank(const std::string& mode) {
  if (mode == "procedural") return;
  photos_ = pictures_in({"/usr/share/backgrounds", "/usr/share/wallpapers"});
  grounds_ = pictures_in({"/usr/share/games/etr/terrains"});
  if (mode == "photos" && photos_.empty() && grounds_.empty()) {
    throw InputError(
        "simulation.textures = 'photos': no photographs found under /usr/share/backgrounds or "
        "/usr/share/games/etr; install the packages of tools/texture_packages.txt or use "
        "'procedural'");
  }
}

Texture TextureBank::make(Material material, Random random) const {
  const bool on_ground = lies_on_the_ground(material) && !grounds_.empty();
  const auto& files = on_ground ? grounds_ : photos_;
  const double share = wants_whole_picture(material) ? 0.85 : 0.5;
  if (files.empty() || !may_be_photo(material) || !random.chance(share)) {
    return draw_material(material, random.fork(1));
  }
  const auto pick =
      static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(files.size()) - 1));
  // Photographs are far larger than a tile; ground textures are not.
  const auto flags = on_ground ? cv::IMREAD_GRAYSCALE : cv::IMREAD_REDUCED_GRAYSCALE_2;
  const cv::Mat1b photo = cv::imread(files[pick].string(), flags);
  if (photo.empty() || std::min(photo.cols, photo.rows) < 64) {
    return draw_material(material, random.fork(1));
  }
  const cv::Mat1b piece = lively_piece(photo, kTile, random);
  if (wants_whole_picture(material)) return to_texture(piece);
  const Texture drawn = draw_material(material, random.fork(1));
  const double mean = 255.0 * drawn.mean();
  cv::Mat1b tile = mirrored(detail_only(piece, mean, random.uniform(0.8, 1.3)));
  add_detail(tile, drawn, mean);
  return to_texture(tile);
}

std::string TextureBank::description() const {
  if (photos_.empty() && grounds_.empty()) return "procedural";
  std::string list;
  std::size_t count = 0;
  for (const auto* files : {&photos_, &grounds_}) {
    for (const auto& file : *files) {
      list += fmt::format("{} {}\n", file.string(), std::filesystem::file_size(file));
      ++count;
    }
  }
  return fmt::format("photos ({} files, sha256 of their names and sizes {})", count,
                     sha256(list).substr(0, 16));
}

}  // namespace imslam::simulation
