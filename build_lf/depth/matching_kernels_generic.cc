// Matching kernels for any processor.
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

const MatchingKernels kGenericMatching = make_matching_kernels("generic");

}  // namespace raywalk::build_lf
