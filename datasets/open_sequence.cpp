#include "datasets/open_sequence.hpp"

#include <fmt/format.h>

#include <functional>

#include "datasets/euroc.hpp"
#include "datasets/kitti_odometry.hpp"
#include "datasets/kitti_raw.hpp"
#include "datasets/plain.hpp"
#include "datasets/recording.hpp"
#include "slam/base/error.hpp"
#include "slam/base/text.hpp"

namespace imslam::datasets {
namespace {

struct Format {
  std::string name;
  std::string signs;  ///< what a folder of this format holds
  bool (*fits)(const std::filesystem::path&);
  Recording (*read)(const std::filesystem::path&);
};

const std::vector<Format>& formats() {
  static const std::vector<Format> all = {
      {"euroc", "mav0/cam0/data.csv and mav0/cam0/data/", &looks_like_euroc, &read_euroc},
      {"tumvi", "as euroc, with equidistant cameras or dso/camchain.yaml", &looks_like_euroc,
       &read_euroc},
      {"kitti_odometry", "calib.txt, times.txt, image_0/ and image_1/", &looks_like_kitti_odometry,
       &read_kitti_odometry},
      {"kitti_raw", "a folder named DATE_drive_NUMBER_sync with image_00/ and image_01/",
       &looks_like_kitti_raw, &read_kitti_raw},
      {"plain", "left/ and right/ with calib.yaml or camchain-imucam.yaml", &looks_like_plain,
       &read_plain},
  };
  return all;
}

const Format& format_named(const std::string& name) {
  for (const Format& format : formats()) {
    if (format.name == name) return format;
  }
  const auto nearest = nearest_name(name, sequence_formats());
  throw InputError(fmt::format("unknown dataset format '{}'; use auto, {}{}", name,
                               fmt::join(sequence_formats(), ", "),
                               nearest ? fmt::format(" (did you mean {}?)", *nearest) : ""),
                   ExitCode::kUsage);
}

const Format& format_of(const std::filesystem::path& folder) {
  for (const Format& format : formats()) {
    if (format.fits(folder)) return format;
  }
  std::string looked_for;
  for (const Format& format : formats()) {
    looked_for += fmt::format("\n  {:<15} {}", format.name, format.signs);
  }
  throw InputError(
      fmt::format("{}: no known dataset here; looked for{}\ngive the folder that "
                  "holds these, or name the format",
                  folder.string(), looked_for));
}

/// "sequences/00/" and "." end in the name of a folder as well: readers look at it and beside it.
std::filesystem::path named_folder(const std::filesystem::path& given) {
  if (given.empty()) return given;
  return std::filesystem::absolute(given / ".").lexically_normal().parent_path();
}

Recording read_existing(const std::filesystem::path& given, const std::string& format) {
  if (format != "auto") format_named(format);
  const std::filesystem::path folder = named_folder(given);
  // KITTI raw drives may be named by their odometry number, which is no folder.
  if (!std::filesystem::is_directory(folder) && !looks_like_kitti_raw(folder)) {
    throw InputError(given.string() + (std::filesystem::exists(given)
                                           ? ": is a file; give the folder of a sequence"
                                           : ": no such folder; check the path"));
  }
  const Format& chosen = format == "auto" ? format_of(folder) : format_named(format);
  return chosen.read(folder);
}

}  // namespace

Recording read_recording(const std::filesystem::path& folder, const std::string& format) {
  try {
    return read_existing(folder, format);
  } catch (const std::filesystem::filesystem_error& error) {
    // Links in a circle, folders without permission, broken disks.
    throw InputError(fmt::format("{}: cannot be read ({}); check links and permissions",
                                 error.path1().string(), error.code().message()));
  }
}

std::unique_ptr<Sequence> open_sequence(const std::filesystem::path& folder,
                                        const std::string& format) {
  return make_sequence(read_recording(folder, format));
}

std::vector<std::string> sequence_formats() {
  std::vector<std::string> names;
  for (const Format& format : formats()) names.push_back(format.name);
  return names;
}

}  // namespace imslam::datasets
