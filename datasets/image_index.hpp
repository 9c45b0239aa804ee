#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace imslam::datasets {

/// One image and its stamp, as an index file or a file name states it.
struct ImageEntry {
  std::int64_t time_ns = 0;
  std::string file;      ///< relative to the image folder
  std::size_t line = 0;  ///< of the index file; 0 where the file name is the stamp
};

/// The images of one instant; an empty name stands for a missing one.
struct FramePair {
  std::int64_t time_ns = 0;
  std::string left;
  std::string right;
};

/// Images that stand at most this far behind are sorted in; more is an error. One interval of a
/// 10 Hz camera, with some jitter.
inline constexpr std::int64_t kMaxImageLatenessNs = 150'000'000;

/// Reads `time_ns, file` lines (EuRoC cam0/data.csv).
/// InputError(kData) as CsvReader, or if a name leads out of its folder.
std::vector<ImageEntry> read_image_index(const std::filesystem::path& csv);

/// The images of a folder whose names are stamps in nanoseconds, sorted by stamp.
/// InputError(kData) if there is none.
std::vector<ImageEntry> list_stamped_images(const std::filesystem::path& folder);

/// Names of the PNG and JPEG files in a folder, numbered ones in the order of their numbers; empty
/// if there is no such folder.
std::vector<std::string> list_images(const std::filesystem::path& folder);

/// Which image belongs to which frame: in order if there is one for each, else by the number in
/// its name (from 0); frames without image get an empty name.
std::vector<std::string> names_by_frame(const std::vector<std::string>& names,
                                        std::size_t frame_count);

/// Strictly increasing stamps: sorts late entries, drops repeated stamps (the first one stays); one
/// warning. InputError(kData) "name:line: ..." if an entry is later than kMaxImageLatenessNs.
std::vector<ImageEntry> clean_images(std::vector<ImageEntry> entries, const std::string& name);

/// Merges two cleaned indexes. Stamps within a quarter of the frame interval (at most 5 ms) belong
/// together; images without partner keep their place in time with the other name empty.
/// InputError(kData) if no image has a partner.
std::vector<FramePair> pair_images(const std::vector<ImageEntry>& left,
                                   const std::vector<ImageEntry>& right,
                                   const std::string& name);

}  // namespace imslam::datasets
