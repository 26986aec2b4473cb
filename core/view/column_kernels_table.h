// The compiled sets of column kernels; column_kernels.cc picks one.
#pragma once

#include "core/view/column_kernels.h"

namespace raywalk {

extern const ColumnKernels kGenericKernels;
extern const ColumnKernels kAvx2Kernels;  // only with RAYWALK_HAVE_AVX2_KERNELS

}  // namespace raywalk
