/* alloc.h - the one allocator of the library: sizes are checked, failure is an sct_status. */
#ifndef SCATTER_ALLOC_H
#define SCATTER_ALLOC_H

#include <stdlib.h>

#include "scatter/status.h"

/* *out (a pointer to a pointer) = memory for n >= 0 items of `size` bytes, at least one byte;
 * NULL on failure. SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_alloc(void *out, int64_t n, size_t size, sct_error *err);
SCT_NODISCARD sct_status sct_alloc_zero(void *out, int64_t n, size_t size, sct_error *err);

/* Makes *inout hold n items, keeping what it holds; untouched on failure. */
SCT_NODISCARD sct_status sct_realloc(void *inout, int64_t n, size_t size, sct_error *err);

/* Frees *inout and sets it to NULL. */
void sct_release(void *inout);

#endif
