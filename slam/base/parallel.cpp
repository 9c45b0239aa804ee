#include "slam/base/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <memory>
#include <thread>

#include "slam/base/error.hpp"

namespace imslam {
namespace {

std::unique_ptr<tbb::global_control>& control() {
  static std::unique_ptr<tbb::global_control> instance;
  return instance;
}

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
  tbb::parallel_for(std::size_t{0}, count, body);
}

}  // namespace imslam
