#include "allowance.h"

#include <errno.h>

static const double pause = 1; /* (s) between counts */

bool allowance_take(allowance *a, int64_t size, int64_t most, double now,
                    const allowance_counter *c) {
  const bool is_known = a->counted > 0;
  if (!is_known || (a->bytes + size > most && now > a->counted + pause)) {
    const int64_t bytes = c->count(c->self, c->owner);
    errno = is_known ? EDQUOT : EHOSTDOWN;
    if (bytes < 0) return false;
    a->bytes = bytes;
    a->counted = now;
  }
  errno = EDQUOT;
  if (a->bytes + size > most) return false;
  a->bytes += size;
  return true;
}
