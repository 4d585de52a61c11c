/* Merges from runs of RUN numbers upwards; what is in order already is only looked at. */
#include "ascend.h"

#include <stdbool.h>
#include <string.h>

enum { RUN = 8 };

static bool ascends(int64_t n, const int32_t *index) {
  int64_t k = 1;
  while (k < n && index[k - 1] < index[k]) k++;
  return k >= n;
}

static void sort_run(int64_t n, int32_t *index) {
  for (int64_t k = 1; k < n; k++) {
    const int32_t moving = index[k];
    int64_t at = k;
    for (; at > 0 && index[at - 1] > moving; at--) index[at] = index[at - 1];
    index[at] = moving;
  }
}

static void merge_runs(int64_t n, int64_t run, const int32_t *from, int32_t *to) {
  for (int64_t low = 0; low < n; low += 2 * run) {
    const int64_t middle = low + run < n ? low + run : n;
    const int64_t high = low + 2 * run < n ? low + 2 * run : n;
    int64_t a = low, b = middle;
    for (int64_t k = low; k < high; k++) {
      const bool first = a < middle && (b == high || from[a] < from[b]);
      to[k] = first ? from[a++] : from[b++];
    }
  }
}

void sct_ascend(int64_t n, int32_t *index, int32_t *other) {
  int32_t *from = index, *to = other;
  if (ascends(n, index)) return;
  for (int64_t low = 0; low < n; low += RUN) sort_run(n - low < RUN ? n - low : RUN, index + low);
  for (int64_t run = RUN; run < n; run *= 2) {
    merge_runs(n, run, from, to);
    int32_t *const swap = from;
    from = to;
    to = swap;
  }
  if (from != index) memcpy(index, from, (size_t)n * sizeof *index);
}
