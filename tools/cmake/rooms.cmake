# One folder is one room is one library: imslam_room(pgo SOURCES ... DEPENDS imslam::lie ... PRIVATE Ceres::ceres)
# makes the target imslam_pgo with the alias imslam::pgo.

set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

find_program(IMSLAM_CCACHE ccache)
if(IMSLAM_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${IMSLAM_CCACHE})
endif()

add_library(imslam_build_flags INTERFACE)
target_compile_options(imslam_build_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -fvisibility=hidden -fstack-protector-strong)
# The hidden default of contraction would let a compiler flag change a trajectory.
target_compile_options(imslam_build_flags INTERFACE -ffp-contract=off)
target_include_directories(imslam_build_flags INTERFACE ${PROJECT_SOURCE_DIR})
# Eigen stays single-threaded: parallel loops are ours (slam/base/parallel.hpp).
target_compile_definitions(imslam_build_flags INTERFACE EIGEN_DONT_PARALLELIZE)
if(IMSLAM_SANITIZE)
  target_compile_options(imslam_build_flags INTERFACE
    -fsanitize=${IMSLAM_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(imslam_build_flags INTERFACE -fsanitize=${IMSLAM_SANITIZE})
  # Debian's Ceres allocates Eigen memory without ASan; both sides must agree on how it is freed.
  target_compile_definitions(imslam_build_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  target_sources(imslam_build_flags INTERFACE
    $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:${PROJECT_SOURCE_DIR}/tools/sanitizers/defaults.cpp>)
elseif(CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_definitions(imslam_build_flags INTERFACE _FORTIFY_SOURCE=2)
endif()

# A third of a small file's processor time goes into the headers that nearly all files read. ccache, where a developer
# has it, saves more than reading them once, and would not share its results between checkouts any more.
if(IMSLAM_CCACHE OR IMSLAM_SANITIZE)
  set(precompile_by_default OFF)
else()
  set(precompile_by_default ON)
endif()
option(IMSLAM_PRECOMPILE "Read the most frequent headers once for all rooms" ${precompile_by_default})
if(IMSLAM_PRECOMPILE)
  add_library(imslam_precompiled OBJECT ${PROJECT_SOURCE_DIR}/tools/cmake/precompiled.cpp)
  target_link_libraries(imslam_precompiled PRIVATE imslam_build_flags Eigen3::Eigen spdlog::spdlog)
  target_precompile_headers(imslam_precompiled PRIVATE
    <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <algorithm> <array> <cmath> <filesystem> <fmt/format.h>
    <functional> <map> <memory> <optional> <string> <utility> <vector>)
endif()

function(imslam_room name)
  cmake_parse_arguments(ROOM "OWN_FLAGS" "" "SOURCES;DEPENDS;PRIVATE" ${ARGN})
  if(ROOM_SOURCES)
    add_library(imslam_${name} STATIC ${ROOM_SOURCES})
    target_link_libraries(imslam_${name}
      PUBLIC Eigen3::Eigen ${ROOM_DEPENDS} PRIVATE imslam_build_flags ${ROOM_PRIVATE})
    target_include_directories(imslam_${name} PUBLIC ${PROJECT_SOURCE_DIR})
    if(IMSLAM_PRECOMPILE AND NOT ROOM_OWN_FLAGS)
      target_precompile_headers(imslam_${name} REUSE_FROM imslam_precompiled)
    endif()
  else()
    add_library(imslam_${name} INTERFACE)
    target_link_libraries(imslam_${name} INTERFACE Eigen3::Eigen ${ROOM_DEPENDS})
    target_include_directories(imslam_${name} INTERFACE ${PROJECT_SOURCE_DIR})
  endif()
  add_library(imslam::${name} ALIAS imslam_${name})
endfunction()

# The trained networks are part of the program: nothing to install, nothing to lose. weights/FILE of this folder is
# embedded by its shipped_weights.cpp, which finds the path in DEFINITION; WITHOUT says what misses it.
function(imslam_embed_weights file definition without)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/weights)  # comes or goes
  set(path ${CMAKE_CURRENT_SOURCE_DIR}/weights/${file})
  if(EXISTS ${path})
    set_property(SOURCE shipped_weights.cpp APPEND PROPERTY COMPILE_DEFINITIONS ${definition}="${path}")
    set_property(SOURCE shipped_weights.cpp APPEND PROPERTY OBJECT_DEPENDS ${path})
  else()
    message(STATUS "no ${path}: ${without} will ask for a weight file")
  endif()
endfunction()

# imslam_test(pgo SOURCES ... DEPENDS imslam::pgo ...): one test executable per room.
set(IMSLAM_TEST_TIMEOUT_S 600 CACHE STRING "Seconds that one test may take; sanitizers need more")
function(imslam_test name)
  cmake_parse_arguments(TEST "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(imslam_${name}_test ${TEST_SOURCES})
  target_link_libraries(imslam_${name}_test PRIVATE imslam_build_flags ${TEST_DEPENDS} GTest::gtest GTest::gtest_main)
  set_target_properties(imslam_${name}_test PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  gtest_discover_tests(imslam_${name}_test
    TEST_PREFIX "${name}." DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT ${IMSLAM_TEST_TIMEOUT_S}
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
endfunction()
