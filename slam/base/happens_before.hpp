#pragma once

/// Order between threads that ThreadSanitizer cannot see, because a library made it that was not
/// built with it.
///
/// What a thread did before happens_before(tag) is done for a thread after its happens_after(tag).
/// The program makes that order by other means; without the sanitizer both are nothing.

#if defined(IMSLAM_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#endif

namespace imslam {

inline void happens_before([[maybe_unused]] const void* tag) {
#if defined(IMSLAM_THREAD_SANITIZER)
  __tsan_release(const_cast<void*>(tag));
#endif
}

inline void happens_after([[maybe_unused]] const void* tag) {
#if defined(IMSLAM_THREAD_SANITIZER)
  __tsan_acquire(const_cast<void*>(tag));
#endif
}

}  // namespace imslam
