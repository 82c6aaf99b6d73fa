// Marks a function to be compiled twice, for every x86-64 and for those with AVX2; the loader picks one. The
// results are the same to the bit: the loops have no sums across samples, and nothing is contracted into
// fused multiply-adds.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define METRIC_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define METRIC_VECTOR_CLONES
#endif
