// Matching kernels for processors with AVX2 (this file alone is compiled with -mavx2).
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "build_lf/depth/matching_kernels.h"
#include "build_lf/depth/matching_kernels_table.h"
#include "core/geometry/fast_math.h"
// Must follow the includes above.
#include "build_lf/depth/matching_kernels_body.inc"

namespace raywalk::build_lf {

const MatchingKernels kAvx2Matching = make_matching_kernels("avx2");

}  // namespace raywalk::build_lf
