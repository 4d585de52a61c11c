#include "typed_array.h"

#include <endian.h>
#include <math.h>
#include <string.h>

double typed_array_half(uint16_t bits) {
  int exponent = (bits >> 10) & 0x1F, fraction = bits & 0x3FF;
  double size = exponent == 0x1F ? (fraction != 0 ? (double)NAN : HUGE_VAL)
                : exponent == 0  ? ldexp(fraction, -24)
                                 : ldexp(fraction + 0x400, exponent - 25);
  return copysign(size, bits & 0x8000 ? -1.0 : 1.0);
}

static double single_of(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return (double)value;
}

static double double_of(uint64_t bits) {
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static uint8_t same(uint8_t byte) {
  return byte;
}

/* One loader per type: raw bits in the order of the wire, host order, the number they stand for. */
#define LOADER(name, raw, host_order, number_of)                        \
  static void name(const unsigned char *bytes, int64_t n, double *to) { \
    for (int64_t k = 0; k < n; k++) {                                   \
      raw bits;                                                         \
      memcpy(&bits, bytes + (size_t)k * sizeof bits, sizeof bits);      \
      to[k] = (double)number_of(host_order(bits));                      \
    }                                                                   \
  }

LOADER(uint8, uint8_t, same, )
LOADER(uint16_big, uint16_t, be16toh, )
LOADER(uint32_big, uint32_t, be32toh, )
LOADER(uint64_big, uint64_t, be64toh, )
LOADER(uint16_little, uint16_t, le16toh, )
LOADER(uint32_little, uint32_t, le32toh, )
LOADER(uint64_little, uint64_t, le64toh, )
LOADER(sint8, uint8_t, same, (int8_t))
LOADER(sint16_big, uint16_t, be16toh, (int16_t))
LOADER(sint32_big, uint32_t, be32toh, (int32_t))
LOADER(sint64_big, uint64_t, be64toh, (int64_t))
LOADER(sint16_little, uint16_t, le16toh, (int16_t))
LOADER(sint32_little, uint32_t, le32toh, (int32_t))
LOADER(sint64_little, uint64_t, le64toh, (int64_t))
LOADER(half_big, uint16_t, be16toh, typed_array_half)
LOADER(single_big, uint32_t, be32toh, single_of)
LOADER(double_big, uint64_t, be64toh, double_of)
LOADER(half_little, uint16_t, le16toh, typed_array_half)
LOADER(single_little, uint32_t, le32toh, single_of)
LOADER(double_little, uint64_t, le64toh, double_of)

/* RFC 8746, table 1, from tag 64 on; 68 is uint8 too (clamped arithmetic), 76 is reserved, 83 and
 * 87 are 128-bit floats. */
enum { FIRST_TAG = 64, TAGS = 24 };
static const typed_array types[TAGS] = {
    {1, uint8},       {2, uint16_big},    {4, uint32_big},    {8, uint64_big},
    {1, uint8},       {2, uint16_little}, {4, uint32_little}, {8, uint64_little},
    {1, sint8},       {2, sint16_big},    {4, sint32_big},    {8, sint64_big},
    {0, NULL},        {2, sint16_little}, {4, sint32_little}, {8, sint64_little},
    {2, half_big},    {4, single_big},    {8, double_big},    {0, NULL},
    {2, half_little}, {4, single_little}, {8, double_little}, {0, NULL},
};

const typed_array *typed_array_of(uint64_t tag) {
  if (tag < FIRST_TAG || tag >= FIRST_TAG + TAGS) return NULL;
  const typed_array *type = &types[tag - FIRST_TAG];
  return type->width == 0 ? NULL : type;
}
