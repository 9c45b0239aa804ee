#include "slam/adaptation/online_adapter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "slam/adaptation/inertial_lesson.hpp"
#include "slam/adaptation/visual_lesson.hpp"
#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/time.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/training/gradients.hpp"
#include "slam/system/known_device.hpp"

namespace imslam::adaptation {
namespace {

using nn::Var;

constexpr double kLeastPast_s = 5.0;  // a shorter past tells little of a sensor

AdaptationOptions online(AdaptationOptions options) {
  options.validate();
  if (options.upper == "published") {
    throw InputError("finetune.upper: published is of whole sequences; use imslam finetune",
                     ExitCode::kUsage);
  }
  options.edges = std::min(options.edges, options.online_every);
  return options;
}

}  // namespace

OnlineAdapter::OnlineAdapter(const system::SlamOptions& slam,
                             const AdaptationOptions& options,
                             const datasets::Sequence& sequence)
    : slam_(slam),
      options_(online(options)),
      sequence_(sequence),
      networks_(slam, options_, {system::present_device(slam, sequence)}),
      camera_(calibrated(sequence.camera(), networks_.device())),
      in_use_(networks_.snapshot()),
      tracer_(
          std::vector<bool>(sequence.frame_count(), true), camera_, networks_.match() != nullptr),
      batch_(networks_.parameters(), std::min(options_.edges + 1, thread_count())),
      gradients_(nn::zero_gradients(networks_.parameters())),
      usable_(static_cast<std::size_t>(options_.edges) + 1, 0) {}

void OnlineAdapter::attach(system::RunRequest& request) {
  request.networks = &in_use_;
  request.device = networks_.device();
  request.observe = [this](const StereoFrame& frame, const vo::VoOutput& seen) {
    see(frame, seen);
  };
  request.observe_window = [this](const pgo::PoseVelocityGraph& window) {
    remember(window);
    if (++windows_ % options_.online_every == 0) learn(window);
  };
}

std::string OnlineAdapter::summary() const {
  return fmt::format("adapted online: {} steps, {} skipped", steps_, skipped_);
}

void OnlineAdapter::see(const StereoFrame& frame, const vo::VoOutput& seen) {
  tracer_.see(frame, seen);
  auto& traces = tracer_.traces();
  const auto most = static_cast<std::size_t>(options_.edges);
  if (traces.size() > most)
    traces.erase(traces.begin(), traces.end() - static_cast<std::ptrdiff_t>(most));
}

/// The oldest state of the window, before it leaves.
void OnlineAdapter::remember(const pgo::PoseVelocityGraph& window) {
  const pgo::State& oldest = window.states().front();
  if (past_states_.empty() || oldest.time_ns > past_states_.back().time_ns) {
    past_states_.push_back(oldest);
  }
  const std::int64_t horizon_ns = oldest.time_ns - to_nanoseconds(options_.online_memory_s);
  const auto first = std::find_if(past_states_.begin(), past_states_.end(),
                                  [&](const auto& state) { return state.time_ns >= horizon_ns; });
  past_states_.erase(past_states_.begin(), first);
}

/// The states that have left the window and those in it, with the readings of that time.
training::InertialLog OnlineAdapter::past(const GraphTeacher& teacher) const {
  const auto& states = teacher.graph().states();
  const std::int64_t end_ns = states.back().time_ns;
  const std::int64_t start_ns = past_states_.front().time_ns - to_nanoseconds(1.0);
  std::vector<ImuSample> samples;
  for (const ImuSample& sample : sequence_.imu()->samples) {
    if (sample.time_ns >= start_ns && sample.time_ns <= end_ns) samples.push_back(sample);
  }
  training::InertialLog log = teacher.inertial_log(samples, sequence_.imu()->noise);
  std::vector<training::InertialLog::TrueState> before;
  const std::int64_t offset_ns = to_nanoseconds(teacher.graph().globals().time_offset_s);
  for (const pgo::State& state : past_states_) {
    const std::int64_t time_ns = state.time_ns + offset_ns;
    if (state.time_ns >= states.front().time_ns || samples.empty()) break;
    if (time_ns >= samples.front().time_ns) before.push_back({time_ns, state.nav});
  }
  log.truth.insert(log.truth.begin(), before.begin(), before.end());
  return log;
}

Var OnlineAdapter::lesson(nn::Tape<float>& tape, const GraphTeacher& teacher, std::size_t slot) {
  const Var nothing = tape.constant(nn::Tensor<float>({1}));
  const auto inertial_slot = static_cast<std::size_t>(options_.edges);
  if (slot == inertial_slot) {
    if (networks_.imu_network() == nullptr || log_.truth.size() < 2) return nothing;
    const InertialClass of{*networks_.imu_network(),        teacher, log_, slam_, options_,
                           [](std::size_t) { return true; }};
    usable_[slot] = 1;
    const Random random = Random(static_cast<std::uint64_t>(options_.seed))
                              .fork(static_cast<std::uint64_t>(windows_));
    return scale(tape, inertial_lesson(tape, of, random), options_.imu_weight * options_.edges);
  }
  if (slot >= tracer_.traces().size()) return nothing;
  const VisualClass of{networks_, teacher, camera_, slam_.vo, options_};
  bool usable = false;
  const Var said = visual_lesson(tape, tracer_.traces()[slot], of, usable);
  usable_[slot] = usable ? 1 : 0;
  return usable ? said : nothing;
}

void OnlineAdapter::learn(const pgo::PoseVelocityGraph& window) {
  std::string reason;
  const auto teacher = GraphTeacher::of(window, options_, reason);
  ++steps_;
  if (!teacher) {
    ++skipped_;
    return;
  }
  log_ = training::InertialLog();
  const double past_s = to_seconds(window.states().back().time_ns - past_states_.front().time_ns);
  if (sequence_.imu() && past_s >= kLeastPast_s) log_ = past(*teacher);
  std::fill(usable_.begin(), usable_.end(), 0);
  const double loss = batch_.run(
      usable_.size(),
      [&](nn::Tape<float>& tape, std::size_t slot) { return lesson(tape, *teacher, slot); },
      gradients_);
  const double norm = nn::clip_network_norms(networks_.parameters(), gradients_, options_.clip);
  const bool any = std::count(usable_.begin(), usable_.end(), 1) > 0;
  if (!any || !std::isfinite(loss) || !std::isfinite(norm)) {
    ++skipped_;
    return;
  }
  optimizer_.step(networks_.parameters(), gradients_, options_.online_rate);
  renew();
}

/// Puts the present weights into the networks that the run holds.
void OnlineAdapter::renew() {
  const system::Networks now = networks_.snapshot();
  const auto replace = [](const auto& held, const auto& by) {
    using Network = std::remove_const_t<typename std::decay_t<decltype(held)>::element_type>;
    if (held) const_cast<Network&>(*held) = *by;  // made in snapshot(), of ours, as not const
  };
  replace(in_use_.match, now.match);
  replace(in_use_.motion_noise, now.motion_noise);
  replace(in_use_.pose_head, now.pose_head);
  replace(in_use_.imu_network, now.imu_network);
}

}  // namespace imslam::adaptation
