#include "slam/base/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <memory>
#include <thread>

#include "slam/base/error.hpp"
#include "slam/base/happens_before.hpp"

namespace imslam {
namespace {

std::unique_ptr<tbb::global_control>& control() {
  static std::unique_ptr<tbb::global_control> instance;
  return instance;
}

/// One loop as oneTBB sees it, with the order of its fork and its join said to ThreadSanitizer.
struct Iteration {
  const std::function<void(std::size_t)>* body;
  const void* forked;
  const void* joined;

  void operator()(std::size_t i) const {
    happens_after(forked);
    (*body)(i);
    happens_before(joined);
  }
};

}  // namespace

void set_thread_count(int threads) {
  expects(threads >= 0, "set_thread_count: threads must be 0 (all cores) or more");
  const auto count = threads > 0 ? static_cast<std::size_t>(threads)
                                 : std::max<std::size_t>(1, std::thread::hardware_concurrency());
  control() =
      std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, count);
}

int thread_count() {
  return static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

struct SingleThreadScope::Limit {
  tbb::global_control control{tbb::global_control::max_allowed_parallelism, 1};
};

SingleThreadScope::SingleThreadScope() : limit_(std::make_unique<Limit>()) {}
SingleThreadScope::~SingleThreadScope() = default;

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  const char forked = 0;
  const char joined = 0;
  happens_before(&forked);
  tbb::parallel_for(std::size_t{0}, count, Iteration{&body, &forked, &joined});
  happens_after(&joined);
}

}  // namespace imslam
