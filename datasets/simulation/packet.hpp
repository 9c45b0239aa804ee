#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace imslam::simulation {

/// Sixteen values that are computed together. The compiler splits them into what the processor
/// has; every operation is done for each lane alone, so the results are the same on all of them.
constexpr std::size_t kLanes = 16;
/// The alignment is said aloud: a compiler for small processors would choose less than the
/// functions that it compiles for large ones rely on.
using Floats = float __attribute__((vector_size(kLanes * sizeof(float)), aligned(64)));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t)), aligned(64)));
struct Floats3 {
  Floats x, y, z;
};
static_assert(alignof(Floats3) == 64);

/// Compiles a function for several processors and picks one at the start of the program. Sanitizers
/// do not get along with the choice.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define IMSLAM_FOR_EACH_PROCESSOR __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define IMSLAM_FOR_EACH_PROCESSOR
#endif

/// Sixteen rays from one place and how they change from one pixel to the next.
struct RayPacket {
  Floats3 direction = {};  ///< unit, world
  Floats3 d_column = {};   ///< change of direction per pixel to the right
  Floats3 d_row = {};      ///< change of direction per pixel downwards
  std::size_t count = 0;   ///< lanes in use, the first ones
};

/// What a camera sees along the rays of a packet.
struct SeenPacket {
  Floats radiance;
  Floats distance;                 ///< [m] along the unit ray; sky: inf
  std::uint32_t surface[kLanes];   ///< differs between smooth pieces and between instances
  std::uint32_t instance[kLanes];  ///< as in Hit; 0 for the sky, which does not move either
};

}  // namespace imslam::simulation
