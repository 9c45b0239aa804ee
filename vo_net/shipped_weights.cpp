#include "vo_net/match_weights.hpp"

#ifdef IMSLAM_MATCH_WEIGHTS

// The assembler copies the file as it is: an array in C++ would compile for minutes.
asm(".pushsection .rodata, \"a\", @progbits\n"
    ".balign 16\n"
    "imslam_match_weights_begin:\n"
    ".incbin \"" IMSLAM_MATCH_WEIGHTS
    "\"\n"
    "imslam_match_weights_end:\n"
    ".byte 0\n"
    ".popsection\n");

extern "C" {
extern const char imslam_match_weights_begin[];
extern const char imslam_match_weights_end[];
}

#endif

namespace imslam::vo {

std::optional<std::string> shipped_match_weights() {
#ifdef IMSLAM_MATCH_WEIGHTS
  return std::string(imslam_match_weights_begin, imslam_match_weights_end);
#else
  return std::nullopt;
#endif
}

}  // namespace imslam::vo
