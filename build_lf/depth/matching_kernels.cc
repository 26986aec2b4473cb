#include "build_lf/depth/matching_kernels.h"

#include <cstring>

#include "build_lf/depth/matching_kernels_table.h"

namespace raywalk::build_lf {

#ifdef RAYWALK_HAVE_X86_MATCHING
namespace {

// The parts that x86-64-v4 adds to AVX2 (System V ABI, x86-64 supplement, 3.1.1).
bool has_avx512() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
}

}  // namespace
#endif

const MatchingKernels* matching_kernels_named(const char* name) {
  if (std::strcmp(name, "generic") == 0) return &kGenericMatching;
#ifdef RAYWALK_HAVE_X86_MATCHING
  if (std::strcmp(name, "avx2") == 0 && __builtin_cpu_supports("avx2")) return &kAvx2Matching;
  if (std::strcmp(name, "avx512") == 0 && has_avx512()) return &kAvx512Matching;
#endif
  return nullptr;
}

const MatchingKernels& matching_kernels() {
  static const MatchingKernels* const best = [] {
    const MatchingKernels* kernels = matching_kernels_named("avx512");
    if (kernels == nullptr) kernels = matching_kernels_named("avx2");
    return kernels != nullptr ? kernels : &kGenericMatching;
  }();
  return *best;
}

}  // namespace raywalk::build_lf
