// Compiles a function twice, for AVX2 and for any x86-64; which one runs is chosen when a program
// is loaded. Its loops are plain C++ that GCC vectorises, with
// structs passed by value: what a reference refers to might change in the loop. Both give the same
// results, as core/view is compiled without fused multiply-adds. Sanitizers need the choice to be
// made before they are ready.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define RAYWALK_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define RAYWALK_VECTOR_CLONES
#endif
// Before a loop whose turns do not depend on each other, whatever its pointers point to.
#if defined(__clang__)
#define RAYWALK_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define RAYWALK_INDEPENDENT _Pragma("GCC ivdep")
#endif
#define RAYWALK_INLINE __attribute__((always_inline)) inline
