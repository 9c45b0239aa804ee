#include "slam/adaptation/epoch.hpp"

#include <algorithm>
#include <numeric>

#include "slam/base/error.hpp"
#include "slam/base/random.hpp"

namespace imslam::adaptation {
namespace {

/// Frames of the run that are not held out, shuffled; the first `count` of them.
std::vector<std::size_t> draw_frames(std::size_t first,
                                     std::size_t last,
                                     const AdaptationOptions& options,
                                     int number) {
  std::vector<std::size_t> frames;
  for (std::size_t i = first + 1; i < last; ++i) {
    if (!is_held_out(i - first, options)) frames.push_back(i);
  }
  Random random =
      Random(static_cast<std::uint64_t>(options.seed)).fork(static_cast<std::uint64_t>(number));
  for (std::size_t i = frames.size(); i > 1; --i) {
    const auto other = random.integer(0, static_cast<std::int64_t>(i) - 1);
    std::swap(frames[i - 1], frames[static_cast<std::size_t>(other)]);
  }
  const auto wanted = static_cast<std::size_t>(options.steps_per_epoch * options.edges);
  frames.resize(std::min(frames.size(), wanted));
  return frames;
}

/// The traces in the order in which their frames were drawn.
std::vector<MotionTrace> in_order(std::vector<MotionTrace>&& traces,
                                  const std::vector<std::size_t>& frames) {
  std::vector<MotionTrace> ordered;
  for (const std::size_t frame : frames) {
    const auto found = std::find_if(traces.begin(), traces.end(), [&](const MotionTrace& trace) {
      return trace.now && trace.now->index == frame;
    });
    if (found != traces.end()) ordered.push_back(std::move(*found));
  }
  return ordered;
}

}  // namespace

std::unique_ptr<Epoch> run_epoch(const EpochRequest& request,
                                 const LearnedNetworks& networks,
                                 const DeviceCalibration& device,
                                 int number,
                                 const std::shared_ptr<vo::MatchRecording>& matches) {
  const std::size_t count = request.sequence.frame_count();
  const std::size_t first = request.run.first_frame;
  const std::size_t last = request.run.last_frame == 0 ? count : request.run.last_frame;
  const auto frames = draw_frames(first, std::min(last, count), request.options, number);
  std::vector<bool> wanted(count, false);
  for (const std::size_t frame : frames) wanted[frame] = true;
  auto epoch = std::make_unique<Epoch>();
  epoch->device = device;
  epoch->camera = calibrated(request.sequence.camera(), epoch->device);
  MotionTracer tracer(std::move(wanted), epoch->camera, networks.match() != nullptr);

  system::Networks snapshot = networks.snapshot();
  if (matches && matches->size() > 0) snapshot.matches = matches;
  if (matches && matches->size() == 0) snapshot.record_matches = matches;
  system::RunRequest run = request.run;
  run.networks = &snapshot;
  run.device = epoch->device;
  run.observe = [&](const StereoFrame& frame, const vo::VoOutput& seen) {
    tracer.see(frame, seen);
  };
  epoch->outcome = system::run_sequence(request.sequence, request.slam, run);
  if (epoch->outcome.stopped) {
    throw InputError("stopped in the middle of an epoch; --resume goes on", ExitCode::kInterrupted);
  }
  epoch->traces = in_order(std::move(tracer.traces()), frames);
  epoch->teacher = GraphTeacher::of(epoch->outcome.result, request.options, epoch->reason);
  if (epoch->teacher && epoch->outcome.result.inertial) {
    epoch->log = epoch->teacher->inertial_log(request.sequence.imu()->samples,
                                              request.sequence.imu()->noise);
  }
  return epoch;
}

}  // namespace imslam::adaptation
