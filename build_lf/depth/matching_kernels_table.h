// The compiled sets of matching kernels; matching_kernels.cc selects one.
#pragma once

#include "build_lf/depth/matching_kernels.h"

namespace raywalk::build_lf {

extern const MatchingKernels kGenericMatching;
// Defined only if RAYWALK_HAVE_X86_MATCHING is.
extern const MatchingKernels kAvx2Matching;
extern const MatchingKernels kAvx512Matching;

}  // namespace raywalk::build_lf
