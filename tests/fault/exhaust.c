#include "exhaust.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scarce.h"

/* No reply for lack of memory, or (UM-Bridge) one that says so. */
static bool says_memory(const reply *r) {
  return r->status == 500 && (!r->bytes || memmem(r->bytes, r->size, "memory", 6));
}

/* One answer with scarce memory; false when there was enough. */
static bool runs_out(const ask *question, int expected, int64_t granted, bool lasting) {
  reply r;
  scarce_after(granted, lasting);
  answer(question, &r);
  const bool failed = scarce_end();
  const bool is_well =
      r.status == expected || r.status == 413 || r.status == 422 || says_memory(&r);
  if (!is_well || (!failed && r.status != expected)) {
    fail_msg("%s, allocation %lld: got %d, needs %d, 413 or 422: %.*s", question->process,
             (long long)granted, r.status, expected, r.bytes ? (int)r.size : 4,
             r.bytes ? (char *)r.bytes : "none");
  }
  free(r.bytes);
  return failed;
}

int64_t exhaust_each(const ask *question, bool lasting, int64_t first, int64_t stride) {
  reply r;
  int64_t failed = 0;
  answer(question, &r);
  const int expected = r.status;
  free(r.bytes);
  for (int64_t n = first; runs_out(question, expected, n, lasting); n += stride) failed++;
  return failed;
}
