#include "datasets/recording.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "datasets/trajectory_file.hpp"
#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

class RecordedSequence final : public ExchangeableSequence {
 public:
  explicit RecordedSequence(Recording recording)
      : recording_(std::move(recording)),
        camera_(recording_.rectifier.camera()),
        logged_(recording_.frames.size(), false) {
    if (!recording_.imu) make_left_camera_the_body();
  }

  std::string format() const override { return recording_.format; }
  std::string name() const override { return recording_.name; }
  const std::filesystem::path& root() const override { return recording_.root; }
  const StereoCamera& camera() const override { return camera_; }
  std::size_t frame_count() const override { return recording_.frames.size(); }
  std::int64_t frame_time_ns(std::size_t index) const override {
    return recording_.frames.at(index).time_ns;
  }
  const std::optional<ImuData>& imu() const override { return recording_.imu; }
  const std::optional<PosePath>& truth() const override { return recording_.truth; }
  const lie::SE3d& T_body_truth() const override { return recording_.T_body_truth; }
  std::vector<std::filesystem::path> input_files() const override { return recording_.input_files; }

  StereoFrame read_frame(std::size_t index) override {
    expects(index < recording_.frames.size(), "read_frame: index beyond the sequence");
    const FramePair& pair = recording_.frames[index];
    DecodedImage left = decode(recording_.left_folder, pair.left);
    DecodedImage right = decode(recording_.right_folder, pair.right);
    log_faults(index, left.fault, right.fault);
    return rectify(index, std::move(left.image), std::move(right.image));
  }

  StereoFrame read_exchanged_frame(std::size_t index) override {
    expects(index < recording_.frames.size(), "read_exchanged_frame: index beyond the sequence");
    const FramePair& pair = recording_.frames[index];
    return rectify(index, decode(recording_.right_folder, pair.right).image,
                   decode(recording_.left_folder, pair.left).image);
  }

 private:
  void make_left_camera_the_body() {
    recording_.T_body_truth = camera_.T_body_left.inverse() * recording_.T_body_truth;
    camera_.T_body_left = lie::SE3d();
  }

  StereoFrame rectify(std::size_t index, GrayImage left, GrayImage right) const {
    StereoFrame frame;
    frame.index = index;
    frame.time_ns = recording_.frames[index].time_ns;
    frame.left = recording_.rectifier.left(std::move(left));
    frame.right = recording_.rectifier.right(std::move(right));
    return frame;
  }

  DecodedImage decode(const std::filesystem::path& folder, const std::string& file) {
    if (file.empty()) return {GrayImage(), "missing in the index"};
    return decoder_.decode(folder / file, ImageSize{camera_.width, camera_.height});
  }

  void log_faults(std::size_t index, const std::string& left, const std::string& right) {
    if ((left.empty() && right.empty()) || logged_[index]) return;
    logged_[index] = true;
    const FramePair& pair = recording_.frames[index];
    std::string text;
    if (!left.empty()) text += " left image " + pair.left + ": " + left;
    if (!right.empty())
      text += (text.empty() ? "" : ";") + (" right image " + pair.right + ": ") + right;
    log::warn("frame {} ({} ns):{}", index, pair.time_ns, text);
  }

  Recording recording_;
  StereoCamera camera_;
  ImageDecoder decoder_;
  std::vector<bool> logged_;
};

void check_image_size(const Recording& recording) {
  std::vector<std::string> left;
  std::vector<std::string> right;
  for (const FramePair& pair : recording.frames) {
    if (!pair.left.empty()) left.push_back(pair.left);
    if (!pair.right.empty()) right.push_back(pair.right);
  }
  const StereoCamera& camera = recording.rectifier.camera();
  const std::pair<const std::filesystem::path&, std::vector<std::string>&> sides[] = {
      {recording.left_folder, left}, {recording.right_folder, right}};
  for (const auto& [folder, names] : sides) {
    const auto size = common_image_size(folder, names);
    if (!size) {
      throw InputError(folder.string() +
                       ": no readable PNG or JPEG image where the index expects "
                       "one; check that the images are unpacked here");
    }
    if (!(*size == ImageSize{camera.width, camera.height})) {
      fail_calibration(
          recording.calibration_file,
          fmt::format("the calibration is for images of {}x{} px, those in {} have "
                      "{}x{} px; scale the intrinsics or use the original images",
                      camera.width, camera.height, folder.string(), size->width, size->height));
    }
  }
}

/// Frames so close or so far apart were stamped in another unit.
void check_frame_interval(const Recording& recording) {
  constexpr double kLeast_s = 1.0 / 5000.0;
  constexpr double kLargest_s = 20.0;
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < recording.frames.size(); ++i) {
    steps.push_back(recording.frames[i].time_ns - recording.frames[i - 1].time_ns);
  }
  if (steps.empty()) return;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double step_s = to_seconds(*middle);
  if (step_s >= kLeast_s && step_s <= kLargest_s) return;
  throw InputError(fmt::format(
      "{}: the stamps of frames advance by {:g} s, which no camera does; they are in another unit, "
      "or only numbers: write nanoseconds (EuRoC, names of images) or seconds (times.txt)",
      recording.root.string(), step_s));
}

}  // namespace

std::unique_ptr<Sequence> make_sequence(Recording recording) {
  if (recording.frames.empty()) {
    throw InputError(recording.root.string() + ": no stereo frames; is the index empty?");
  }
  check_frame_interval(recording);
  check_image_size(recording);
  return std::make_unique<RecordedSequence>(std::move(recording));
}

void read_truth_file(const std::filesystem::path& file,
                     const std::string& frame,
                     Recording& recording) {
  try {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) {
      throw InputError(file.string() + ": not a regular file; put the trajectory itself there");
    }
    recording.truth = read_trajectory(file);
    recording.truth->frame = frame;
    recording.input_files.push_back(file);
  } catch (const InputError& error) {
    log::warn("{}; the truth is not used", error.what());
    recording.truth_fault.emplace(error.what(), ExitCode::kData);
  }
}

std::optional<ImageSize> common_image_size(const std::filesystem::path& folder,
                                           const std::vector<std::string>& names) {
  constexpr std::size_t kProbes = 9;
  std::vector<std::pair<ImageSize, int>> votes;
  const std::size_t step = std::max<std::size_t>(1, names.size() / kProbes);
  for (int pass = 0; pass < 2 && votes.empty(); ++pass) {
    // Almost always a few probes tell; only a folder of damaged images is read in full.
    for (std::size_t i = 0; i < names.size(); i += pass == 0 ? step : 1) {
      const auto size = probe_image_size(folder / names[i]);
      if (!size) continue;
      const auto same = std::find_if(votes.begin(), votes.end(),
                                     [&](const auto& vote) { return vote.first == *size; });
      if (same == votes.end()) {
        votes.emplace_back(*size, 1);
      } else {
        ++same->second;
      }
      if (pass == 1) break;
    }
  }
  if (votes.empty()) return std::nullopt;
  return std::max_element(votes.begin(), votes.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

std::string folder_name(const std::filesystem::path& folder) {
  auto path = std::filesystem::absolute(folder).lexically_normal();
  while (path.has_relative_path() && (path.filename().empty() || path.filename() == "mav0")) {
    path = path.parent_path();
  }
  return path.has_relative_path() ? path.filename().string() : "sequence";
}

}  // namespace imslam::datasets
