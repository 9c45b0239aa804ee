#include "datasets/image_index.hpp"

#include <algorithm>
#include <cctype>
#include <limits>

#include "datasets/csv.hpp"
#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/base/text.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

constexpr std::int64_t kMaxPairingNs = 5'000'000;

bool leads_out_of_folder(const std::filesystem::path& name) {
  if (name.is_absolute()) return true;
  return std::any_of(name.begin(), name.end(), [](const auto& part) { return part == ".."; });
}

bool is_image_name(const std::filesystem::path& name) {
  std::string extension = name.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

/// 2.png before 10.png: numbered images in the order of their numbers.
bool in_natural_order(const std::string& a, const std::string& b) {
  const auto number_a = parse_int64(std::filesystem::path(a).stem().string());
  const auto number_b = parse_int64(std::filesystem::path(b).stem().string());
  if (number_a && number_b && *number_a != *number_b) return *number_a < *number_b;
  if (number_a.has_value() != number_b.has_value()) return number_a.has_value();
  return a < b;
}

std::size_t sort_late(std::vector<ImageEntry>& entries, const std::string& name) {
  std::size_t late = 0;
  std::int64_t latest = std::numeric_limits<std::int64_t>::min();
  for (const ImageEntry& entry : entries) {
    if (entry.time_ns < latest) {
      if (latest - entry.time_ns > kMaxImageLatenessNs) {
        throw InputError(
            fmt::format("{}:{}: image stamp {} is {:.3f} s before an earlier line, at "
                        "most {:.2f} s can be sorted; sort the file, or cut it where "
                        "the clock was set back",
                        name, entry.line, entry.time_ns, to_seconds(latest - entry.time_ns),
                        to_seconds(kMaxImageLatenessNs)));
      }
      ++late;
    }
    latest = std::max(latest, entry.time_ns);
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const ImageEntry& a, const ImageEntry& b) { return a.time_ns < b.time_ns; });
  return late;
}

std::int64_t median_interval_ns(const std::vector<ImageEntry>& entries) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < entries.size(); ++i) {
    intervals.push_back(entries[i].time_ns - entries[i - 1].time_ns);
  }
  if (intervals.empty()) return 4 * kMaxPairingNs;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

}  // namespace

std::vector<ImageEntry> read_image_index(const std::filesystem::path& csv) {
  using Kind = CsvColumn::Kind;
  CsvReader reader(LineReader(csv), {{"time [ns]", Kind::kTime}, {"file name", Kind::kText}});
  std::vector<ImageEntry> entries;
  while (reader.next()) {
    ImageEntry entry{reader.time_ns(0), std::string(reader.text(1)), reader.line_number()};
    if (leads_out_of_folder(entry.file)) {
      throw InputError(reader.where() +
                       ": the image name leads out of its folder; write the bare "
                       "file name");
    }
    entries.push_back(std::move(entry));
  }
  if (reader.cut_off()) log::warn("{}: the last line is cut off and was skipped", csv.string());
  return entries;
}

std::vector<std::string> list_images(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (is_image_name(entry->path())) names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end(), in_natural_order);
  return names;
}

std::vector<ImageEntry> list_stamped_images(const std::filesystem::path& folder) {
  std::vector<ImageEntry> entries;
  for (const std::string& name : list_images(folder)) {
    const auto time_ns = parse_int64(std::filesystem::path(name).stem().string());
    if (time_ns && std::abs(*time_ns) <= kMaxTimeNs) entries.push_back({*time_ns, name, 0});
  }
  if (entries.empty()) {
    throw InputError(folder.string() +
                     ": no images named by their stamp in nanoseconds; add an index file");
  }
  return clean_images(std::move(entries), folder.string());
}

std::vector<ImageEntry> clean_images(std::vector<ImageEntry> entries, const std::string& name) {
  const std::size_t late = sort_late(entries, name);
  const std::size_t before = entries.size();
  entries.erase(
      std::unique(entries.begin(), entries.end(),
                  [](const ImageEntry& a, const ImageEntry& b) { return a.time_ns == b.time_ns; }),
      entries.end());
  if (late > 0 || entries.size() < before) {
    log::warn("{}: sorted {} late images, dropped {} with a repeated stamp", name, late,
              before - entries.size());
  }
  return entries;
}

std::vector<std::string> names_by_frame(const std::vector<std::string>& names,
                                        std::size_t frame_count) {
  if (names.size() == frame_count) return names;
  std::vector<std::string> by_frame(frame_count);
  for (const std::string& name : names) {
    const auto number = parse_int64(std::filesystem::path(name).stem().string());
    if (number && *number >= 0 && static_cast<std::uint64_t>(*number) < frame_count) {
      by_frame[static_cast<std::size_t>(*number)] = name;
    }
  }
  return by_frame;
}

std::vector<FramePair> pair_images(const std::vector<ImageEntry>& left,
                                   const std::vector<ImageEntry>& right,
                                   const std::string& name) {
  const std::int64_t tolerance_ns = std::min(kMaxPairingNs, median_interval_ns(left) / 4);
  std::vector<FramePair> pairs;
  std::size_t complete = 0;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < left.size() || j < right.size()) {
    const bool has_both = i < left.size() && j < right.size();
    const std::int64_t lag_ns = has_both ? right[j].time_ns - left[i].time_ns : 0;
    if (has_both && std::abs(lag_ns) <= tolerance_ns) {
      pairs.push_back({left[i].time_ns, left[i].file, right[j].file});
      ++complete, ++i, ++j;
    } else if (j == right.size() || (has_both && lag_ns > 0)) {
      pairs.push_back({left[i].time_ns, left[i].file, ""});
      ++i;
    } else {
      pairs.push_back({right[j].time_ns, "", right[j].file});
      ++j;
    }
  }
  if (complete == 0) {
    throw InputError(
        fmt::format("{}: no left image ({}) has a right one ({}) within {:.1f} ms; "
                    "check that both cameras use one clock",
                    name, left.size(), right.size(), to_seconds(tolerance_ns) * 1e3));
  }
  if (complete < pairs.size()) {
    log::warn("{}: {} of {} frames lack the left or the right image", name, pairs.size() - complete,
              pairs.size());
  }
  return pairs;
}

}  // namespace imslam::datasets
