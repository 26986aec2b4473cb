#include "core/view/column_kernels.h"

#include <cstring>

#include "core/view/column_kernels_table.h"

namespace raywalk {

const ColumnKernels* column_kernels_named(const char* name) {
  if (std::strcmp(name, "generic") == 0) return &kGenericKernels;
#ifdef RAYWALK_HAVE_AVX2_KERNELS
  if (std::strcmp(name, "avx2") == 0 && __builtin_cpu_supports("avx2")) return &kAvx2Kernels;
#endif
  return nullptr;
}

const ColumnKernels& column_kernels() {
  static const ColumnKernels* const best = [] {
    const ColumnKernels* avx2 = column_kernels_named("avx2");
    return avx2 != nullptr ? avx2 : &kGenericKernels;
  }();
  return *best;
}

}  // namespace raywalk
