// What the sanitizers must know of this program: part of every executable of the presets asan and
// tsan, so that tests, the processes that they start and runs by hand behave alike. ASAN_OPTIONS,
// TSAN_OPTIONS ... add to it.

#define IMSLAM_SANITIZER_DEFAULT extern "C" __attribute__((visibility("default"), used))

// NOLINTBEGIN(bugprone-reserved-identifier): the names that the sanitizers look for

// Initialisation order across files is checked too.
IMSLAM_SANITIZER_DEFAULT const char* __asan_default_options() {
  return "strict_init_order=1:detect_stack_use_after_return=1";
}

IMSLAM_SANITIZER_DEFAULT const char* __ubsan_default_options() { return "print_stacktrace=1"; }

// `imslam bench --jobs` forks before it starts threads of its own, but pools of libraries may
// exist.
IMSLAM_SANITIZER_DEFAULT const char* __tsan_default_options() {
  return "die_after_fork=0:second_deadlock_stack=1:history_size=4:ignore_noninstrumented_modules=1";
}

// NOLINTEND(bugprone-reserved-identifier)
