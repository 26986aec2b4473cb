// Column kernels for processors with AVX2 (this file alone is compiled with -mavx2).
#include <immintrin.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/view/column_kernels.h"
#include "core/view/column_kernels_body.inc"
#include "core/view/column_kernels_table.h"

namespace raywalk {

const ColumnKernels kAvx2Kernels = make_kernels("avx2");

}  // namespace raywalk
