# Writes version.cpp with the present git hash; touches the file only if the hash has changed.
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=10 --match=none
  OUTPUT_VARIABLE IMSLAM_GIT_HASH OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT IMSLAM_GIT_HASH)
  set(IMSLAM_GIT_HASH "unknown")
endif()
configure_file(${SOURCE_DIR}/app/version.cpp.in ${OUTPUT} @ONLY)
