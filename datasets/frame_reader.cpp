#include "datasets/frame_reader.hpp"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include "slam/base/error.hpp"

namespace imslam::datasets {

class FrameReader::Worker {
 public:
  Worker(Sequence& sequence, std::size_t first, std::size_t last, std::size_t ahead)
      : sequence_(sequence), first_(first), last_(last), ahead_(ahead), thread_([this] {
          run();
        }) {}

  ~Worker() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    space_.notify_all();
    thread_.join();
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  std::optional<StereoFrame> next() {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, [this] { return !frames_.empty() || finished_; });
    if (frames_.empty()) {
      if (failure_) std::rethrow_exception(failure_);
      return std::nullopt;
    }
    StereoFrame frame = std::move(frames_.front());
    frames_.pop_front();
    lock.unlock();
    space_.notify_one();
    return frame;
  }

 private:
  void run() {
    std::exception_ptr failure;
    try {
      for (std::size_t index = first_; index < last_ && wait_for_space(); ++index) {
        push(sequence_.read_frame(index));
      }
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      failure_ = failure;
      finished_ = true;
    }
    filled_.notify_all();
  }

  bool wait_for_space() {
    std::unique_lock lock(mutex_);
    space_.wait(lock, [this] { return stop_ || frames_.size() < ahead_; });
    return !stop_;
  }

  void push(StereoFrame frame) {
    {
      const std::lock_guard lock(mutex_);
      frames_.push_back(std::move(frame));
    }
    filled_.notify_one();
  }

  Sequence& sequence_;
  const std::size_t first_;
  const std::size_t last_;
  const std::size_t ahead_;

  std::mutex mutex_;
  std::condition_variable space_;   ///< signalled when a frame is taken
  std::condition_variable filled_;  ///< signalled when a frame is added or the work is done
  std::deque<StereoFrame> frames_;
  bool stop_ = false;
  bool finished_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  ///< last member: starts when all others exist
};

FrameReader::FrameReader(Sequence& sequence,
                         std::size_t first,
                         std::size_t last,
                         std::size_t ahead) {
  expects(first <= last && last <= sequence.frame_count(),
          "FrameReader: range beyond the sequence");
  expects(ahead > 0, "FrameReader: ahead must be positive");
  worker_ = std::make_unique<Worker>(sequence, first, last, ahead);
}

FrameReader::~FrameReader() = default;

std::optional<StereoFrame> FrameReader::next() { return worker_->next(); }

}  // namespace imslam::datasets
