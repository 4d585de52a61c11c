/* length.h - Euclidean length of a short vector, whatever its size. */
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

#endif
