// Column kernels for processors with AVX2 (this file alone is compiled with -mavx2).
#include <immintrin.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "render/view/column_kernels.h"
#include "render/view/column_kernels_body.inc"
#include "render/view/column_kernels_table.h"

namespace raywalk::render {

const ColumnKernels kAvx2Kernels = make_kernels("avx2");

}  // namespace raywalk::render
