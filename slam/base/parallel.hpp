#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace imslam {

/// Threads that parallel_for may use, process-wide; 0 means all cores. Called once by `app`.
void set_thread_count(int threads);
int thread_count();

/// Calls body(i) for every i in [0, count), in any order, on the shared pool (oneTBB).
///
/// body(i) must write only to slot i: then the result does not depend on the thread count.
/// Sums over i are taken afterwards by the caller, in order.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

/// While it lives, everything on oneTBB, libraries included, runs on the calling thread: for
/// libraries whose result would depend on how they share their work out.
class SingleThreadScope {
 public:
  SingleThreadScope();
  ~SingleThreadScope();
  SingleThreadScope(const SingleThreadScope&) = delete;
  SingleThreadScope& operator=(const SingleThreadScope&) = delete;

 private:
  struct Limit;
  std::unique_ptr<Limit> limit_;
};

}  // namespace imslam
