#include "datasets/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "datasets/check_files.hpp"
#include "datasets/check_imu.hpp"
#include "datasets/check_vision.hpp"
#include "datasets/imu_csv.hpp"
#include "datasets/recording.hpp"
#include "slam/base/config.hpp"

namespace imslam::datasets {
namespace {

constexpr std::size_t kListedFaults = 5;

/// Frame indexes: all, or `samples` evenly spread ones.
std::vector<std::size_t> frames_to_decode(std::size_t count, const CheckOptions& options) {
  const auto samples = static_cast<std::size_t>(options.image_samples);
  std::vector<std::size_t> frames;
  const std::size_t wanted = options.all_images ? count : std::min(count, samples);
  for (std::size_t i = 0; i < wanted; ++i) frames.push_back(i * count / wanted);
  return frames;
}

/// Counts what is wrong with images; lists the first few by file.
class ImageFaults {
 public:
  explicit ImageFaults(Findings& findings) : findings_(findings) {}

  void add(const std::filesystem::path& file, const std::string& fault) {
    if (++count_ <= kListedFaults) {
      findings_.warn("image " + fault, "the frame counts as missing", file.string());
    }
  }
  std::size_t count() const { return count_; }

 private:
  Findings& findings_;
  std::size_t count_ = 0;
};

void check_pairing(const Recording& recording, Findings& findings) {
  std::size_t without_left = 0;
  std::size_t without_right = 0;
  for (const FramePair& pair : recording.frames) {
    without_left += pair.left.empty() ? 1 : 0;
    without_right += pair.right.empty() ? 1 : 0;
  }
  if (without_left + without_right == 0) return;
  findings.warn(fmt::format("{} frames lack the left image, {} the right one, of {}", without_left,
                            without_right, recording.frames.size()),
                "they keep their place and are bridged by the IMU");
}

/// Every file is looked for; a sample (or all) is decoded.
void check_images(const Recording& recording, const CheckOptions& options, Findings& findings) {
  const StereoCamera& camera = recording.rectifier.camera();
  const ImageSize size{camera.width, camera.height};
  const auto decoded = frames_to_decode(recording.frames.size(), options);
  const std::set<std::size_t> decode(decoded.begin(), decoded.end());
  ImageDecoder decoder;
  ImageFaults faults(findings);
  std::size_t dark = 0;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const FramePair& pair = recording.frames[i];
    const std::filesystem::path sides[] = {recording.left_folder / pair.left,
                                           recording.right_folder / pair.right};
    const bool named[] = {!pair.left.empty(), !pair.right.empty()};
    for (int side = 0; side < 2; ++side) {
      std::error_code ignored;
      if (!named[side]) continue;
      if (decode.count(i) == 0) {
        if (!std::filesystem::exists(sides[side], ignored)) faults.add(sides[side], "missing");
        continue;
      }
      const DecodedImage image = decoder.decode(sides[side], size);
      if (!image.fault.empty()) {
        faults.add(sides[side], image.fault);
        continue;
      }
      const auto [low, high] =
          std::minmax_element(image.image.pixels.begin(), image.image.pixels.end());
      dark += *high - *low < 10 ? 1 : 0;
    }
  }
  findings.info(
      fmt::format("{}x{} px, fx {:.2f}, fy {:.2f}, cx {:.2f}, cy {:.2f}, baseline {:.4f} m "
                  "after rectification; {} of {} pairs decoded, {} images missing or "
                  "damaged",
                  camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
                  camera.baseline_m, decoded.size(), recording.frames.size(), faults.count()));
  if (dark > 0) {
    findings.warn(fmt::format("{} images are uniform (black, white or covered)", dark),
                  "they tell nothing about motion");
  }
}

/// The open recording as a whole. Whatever InputError stops a step becomes a finding.
void check_recording(const std::filesystem::path& folder,
                     const CheckOptions& options,
                     Findings& findings) {
  Recording recording = read_recording(folder, options.format);
  const std::string calibration_file = recording.calibration_file;
  findings.about(recording.root.string());
  check_pairing(recording, findings);
  check_images(recording, options, findings);
  const std::string imu_file = [&] {
    for (const auto& file : recording.input_files) {
      const std::string name = file.string();
      if (name.find("imu0/data.csv") != std::string::npos || file.filename() == "imu.csv") {
        return name;
      }
    }
    return std::string();
  }();
  if (recording.truth_fault) findings.fail(*recording.truth_fault);
  const auto sequence = make_sequence(std::move(recording));
  findings.info("format " + sequence->format() + ", sequence " + sequence->name());
  check_timing(*sequence, imu_file, findings);
  if (sequence->imu()) check_imu_values(*sequence->imu(), imu_file, findings);
  findings.about(calibration_file);
  if (options.vision_frames > 0) check_vision(*sequence, options.vision_frames, findings);
}

/// What the samples alone tell where the recording as a whole cannot be opened.
void check_samples_alone(const std::filesystem::path& folder, Findings& findings) {
  for (const auto& file : imu_files(folder)) {
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) continue;
    ImuData imu;
    imu.samples = read_imu_csv(file).samples;
    check_samples(imu, file.string(), findings);
    check_imu_values(imu, file.string(), findings);
  }
}

bool same_error(const Finding& a, const Finding& b) {
  return a.severity == Severity::kError && b.severity == Severity::kError && a.file == b.file &&
         a.line == b.line && (a.line > 0 || a.what == b.what);
}

/// Opening stops at an error that the line-by-line check has listed already.
std::vector<Finding> without_repetitions(const std::vector<Finding>& all) {
  std::vector<Finding> result;
  for (const Finding& finding : all) {
    const bool known = std::any_of(result.begin(), result.end(), [&](const Finding& other) {
      return same_error(finding, other);
    });
    if (!known) result.push_back(finding);
  }
  return result;
}

}  // namespace

void CheckOptions::describe(Config& config) {
  config.field("format", format, "format of the recording, or auto");
  config.field("all_images", all_images, "decode every image instead of a sample");
  config.field("image_samples", image_samples, "pairs to decode if not all");
  config.field("vision_frames", vision_frames, "frames for geometry and clock; 0: none");
}

void CheckOptions::validate() const {
  if (image_samples < 1) {
    throw InputError(fmt::format("check.image_samples is {}, expected at least 1", image_samples),
                     ExitCode::kUsage);
  }
  if (vision_frames < 0 || vision_frames > 100000) {
    throw InputError(fmt::format("check.vision_frames is {}, expected 0 to 100000", vision_frames),
                     ExitCode::kUsage);
  }
}

std::vector<Finding> check_sequence(const std::filesystem::path& given,
                                    const CheckOptions& options) {
  options.validate();
  // Readers name files by their whole path: so that the same finding has the same name.
  const auto folder = given.empty() ? given : std::filesystem::absolute(given).lexically_normal();
  Findings findings;
  try {
    check_files(folder, findings);
  } catch (const std::filesystem::filesystem_error&) {
    // Opening it, next, says what is wrong with the folder.
  }
  try {
    check_recording(folder, options, findings);
  } catch (const InputError& error) {
    findings.fail(error);
    try {
      check_samples_alone(folder, findings);
    } catch (const InputError&) {
      // What is wrong with the file is among the findings already.
    } catch (const std::filesystem::filesystem_error&) {
      // And what is wrong with the folder.
    }
  }
  return without_repetitions(findings.all());
}

}  // namespace imslam::datasets
