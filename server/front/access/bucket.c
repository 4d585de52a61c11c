#include "bucket.h"

#include <math.h>

double bucket_take(bucket *b, double rate, double burst, double now) {
  if (now > b->time) b->spent = fmax(0, b->spent - rate * (now - b->time));
  b->time = now;
  if (b->spent + 1 > burst) return (b->spent + 1 - burst) / rate;
  b->spent += 1;
  return 0;
}
