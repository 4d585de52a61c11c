/* length.h - lengths and sums of squares, whatever the size of the numbers. */
#ifndef SCATTER_LENGTH_H
#define SCATTER_LENGTH_H

#include <math.h>

/* |v| of n components, also where their squares are too large or too small for a double. */
static inline double sct_length(const double *v, int n) {
  double square = 0, most = 0, part = 0;
  for (int a = 0; a < n; a++) square += v[a] * v[a];
  if ((square > 0x1p-900 && square < 0x1p1000) || isnan(square)) return sqrt(square);
  for (int a = 0; a < n; a++) most = fmax(most, fabs(v[a]));
  if (most == 0 || isinf(most)) return most;
  for (int a = 0; a < n; a++) part += (v[a] / most) * (v[a] / most);
  return most * sqrt(part);
}

/* A power of two that takes `largest` to about 1, so that squares can be summed: exact. 1 for what
 * no number does that to. */
static inline double sct_scale_of(double largest) {
  int exponent;
  if (!(largest > 0 && isfinite(largest))) return 1;
  (void)frexp(largest, &exponent);
  return ldexp(1, exponent < -1000 ? 1000 : -exponent);
}

#endif
