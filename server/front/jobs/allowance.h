/* allowance.h - bytes within a quota, when to count all of them takes long: what was counted and
 * all that came since, which is never too little; counted again when that seems too much. Test:
 * unit.allowance.
 */
#ifndef SCATTERD_ALLOWANCE_H
#define SCATTERD_ALLOWANCE_H

#include <stdbool.h>
#include <stdint.h>

/* All zero: not counted yet. */
typedef struct {
  int64_t bytes;
  double counted; /* (s), 0: never */
} allowance;

/* How many there really are; -1 when that cannot be known now. */
typedef struct {
  int64_t (*count)(void *self, const char *owner);
  void *self;
  const char *owner;
} allowance_counter;

/* Are there `size` bytes left of `most`? Then they are taken; else errno is EDQUOT, or EHOSTDOWN
 * when that cannot be known now. Counts at most once a second. */
bool allowance_take(allowance *a, int64_t size, int64_t most, double now,
                    const allowance_counter *c);

#endif
