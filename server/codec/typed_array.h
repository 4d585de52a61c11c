/* typed_array.h - numbers packed in bytes, as RFC 8746 tags them. */
#ifndef SCATTERD_TYPED_ARRAY_H
#define SCATTERD_TYPED_ARRAY_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
  size_t width; /* bytes of a number */
  void (*load)(const unsigned char *bytes, int64_t n, double *to);
} typed_array;

/* The array type of a tag; NULL if the tag is none or has none that a double can hold (128-bit
 * floats). 64-bit integers beyond 2^53 are rounded to the nearest double. */
const typed_array *typed_array_of(uint64_t tag);

/* IEEE 754 half precision to double, exactly. */
double typed_array_half(uint16_t bits);

#endif
