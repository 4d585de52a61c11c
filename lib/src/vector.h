/* vector.h - loops over neighbours, compiled once for any x86-64 and once for its wider vectors;
 * the loader picks. Not under a sanitizer, which is not up yet when the loader asks. */
#ifndef SCATTER_VECTOR_H
#define SCATTER_VECTOR_H

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define SCT_VECTOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define SCT_VECTOR
#endif

#endif
