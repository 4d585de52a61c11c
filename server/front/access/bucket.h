/* bucket.h - a token bucket: so many requests a second in the long run, so many at once after a
 * pause. Test: unit.bucket.
 */
#ifndef SCATTERD_BUCKET_H
#define SCATTERD_BUCKET_H

/* All zero: full, whenever it is first used. */
typedef struct {
  double spent; /* of what it holds when full */
  double time;  /* (s) when that was so, any steady clock */
} bucket;

/* Takes one out of a bucket that holds `burst` >= 1 and fills by `rate` (1/s) > 0: 0, or if there
 * is none the time until there is (s). */
double bucket_take(bucket *b, double rate, double burst, double now);

#endif
