// Column kernels for any processor.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "render/view/column_kernels.h"
#include "render/view/column_kernels_body.inc"
#include "render/view/column_kernels_table.h"

namespace raywalk::render {

const ColumnKernels kGenericKernels = make_kernels("generic");

}  // namespace raywalk::render
