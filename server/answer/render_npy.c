/* render_npy.c - one output as an .npy file, version 1.0 of the format (numpy.lib.format). */
#include <stdio.h>
#include <string.h>

#include "render_back.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "arrays are written as they are in memory, little-endian"
#endif

enum { LEAD = 10 /* magic, version, length */, ALIGN = 64, HEADER = 256 };

/* "(4, 3, )", "(4,)" */
static void print_shape(const doc *d, char room[96]) {
  size_t used = 0;
  for (int k = 0; k < d->rank; k++) {
    used += (size_t)snprintf(room + used, 96 - used, "%lld,%s", (long long)d->shape[k],
                             k + 1 < d->rank ? " " : "");
  }
}

static bool put_header(task *t, const doc *d, bool is_integer, rendered *out) {
  char shape[96], text[HEADER];
  print_shape(d, shape);
  int length =
      snprintf(text, sizeof text, "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }",
               is_integer ? "<i4" : "<f8", shape);
  int padded = (LEAD + length + 1 + ALIGN - 1) / ALIGN * ALIGN - LEAD;
  memset(text + length, ' ', (size_t)(padded - length));
  text[padded - 1] = '\n';
  const unsigned char lead[LEAD] = {
      0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, (unsigned char)padded, (unsigned char)(padded >> 8)};
  return put(t, out, lead, sizeof lead) && put(t, out, text, (size_t)padded);
}

static bool put_integers(task *t, const doc *d, rendered *out) {
  int32_t *value = task_take(t, d->count, sizeof *value);
  if (!value) return false;
  for (int64_t k = 0; k < d->count; k++) value[k] = render_integer(d->data[k]);
  return put(t, out, value, (size_t)d->count * sizeof *value);
}

bool render_npy(task *t, const result *r, const result_output *one, rendered *out) {
  const doc *d = one->value;
  const bool is_integer = one->role == OUTPUT_COUNTS;
  (void)r;
  if (d->kind != DOC_NUMBERS) {
    return sct_fail(&t->error, SCT_E_ARGUMENT, -1, "%s is no array", one->name), false;
  }
  if (!put_header(t, d, is_integer, out)) return false;
  if (is_integer) return put_integers(t, d, out);
  return put(t, out, d->data, (size_t)d->count * sizeof *d->data);
}
