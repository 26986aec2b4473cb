// Column kernels for any processor.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/view/column_kernels.h"
#include "core/view/column_kernels_body.inc"
#include "core/view/column_kernels_table.h"

namespace raywalk {

const ColumnKernels kGenericKernels = make_kernels("generic");

}  // namespace raywalk
