/* Short lists in order, whatever runs they come in, by any length. */
#include <stdlib.h>

#include "ascend.h"
#include "fixture.h"

enum { LONGEST = 300 };

static int compare(const void *a, const void *b) {
  const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
  return (x > y) - (x < y);
}

/* `runs` ascending ones, as searches give. */
static void fill(int64_t n, int64_t runs, uint64_t *seed, int32_t *index) {
  for (int64_t k = 0; k < n; k++) index[k] = (int32_t)(1e6 * fixture_random(seed));
  for (int64_t r = 0; r < runs; r++) {
    const int64_t low = n * r / runs, high = n * (r + 1) / runs;
    qsort(index + low, (size_t)(high - low), sizeof *index, compare);
  }
}

static void sorts(void **state) {
  (void)state;
  int32_t index[LONGEST], other[LONGEST], expected[LONGEST];
  uint64_t seed = 7;
  print_message("seed %d\n", 7);
  for (int64_t n = 0; n <= LONGEST; n++) {
    for (int64_t runs = 0; runs <= n; runs += 1 + n / 4) {
      fill(n, runs, &seed, index);
      for (int64_t k = 0; k < n; k++) expected[k] = index[k];
      qsort(expected, (size_t)n, sizeof *expected, compare);
      sct_ascend(n, index, other);
      if (n > 0) assert_memory_equal(index, expected, (size_t)n * sizeof *index);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(sorts)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
