#pragma once

// The assembler copies a file as it is: an array in C++ would compile for minutes.
// IMSLAM_EMBED("symbol", "path") makes extern "C" const char symbol_begin[], symbol_end[].
#define IMSLAM_EMBED(name, file)                 \
  asm(".pushsection .rodata, \"a\", @progbits\n" \
      ".balign 16\n" name                        \
      "_begin:\n"                                \
      ".incbin \"" file "\"\n" name              \
      "_end:\n"                                  \
      ".byte 0\n"                                \
      ".popsection\n")
