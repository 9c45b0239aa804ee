#pragma once

/// Order between threads that ThreadSanitizer cannot see, because a library made it that was not
/// built with it.
///
/// What a thread did before happens_before(tag) is done for a thread after its happens_after(tag).
/// The program makes that order by other means; without the sanitizer both are nothing.

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define IMSLAM_THREAD_SANITIZER
#endif
#endif
#if defined(__SANITIZE_THREAD__)
#define IMSLAM_THREAD_SANITIZER
#endif

#if defined(IMSLAM_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#define IMSLAM_UNSEEN_BY_THREAD_SANITIZER __attribute__((no_sanitize("thread")))
#else
#define IMSLAM_UNSEEN_BY_THREAD_SANITIZER
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
