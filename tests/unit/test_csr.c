/* Sparse matrices against full ones. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../dense.h"
#include "../near.h"
#include "../seed.h"

enum { ROWS = 7, COLUMNS = 5 };

typedef struct {
  double full[ROWS * COLUMNS];
  double x[COLUMNS], b[ROWS]; /* right-hand side of A, and x */
  double y[ROWS], c[COLUMNS]; /* of its transpose */
  sct_csr *a;
} fixture;

static int set_up(void **state) {
  fixture *f = malloc(sizeof *f);
  if (f == NULL) return -1;
  uint64_t seed = seed_new("csr");
  for (int k = 0; k < ROWS * COLUMNS; k++) {
    f->full[k] = seed_below(&seed, 2) ? seed_uniform(&seed, -1, 1) : 0;
  }
  for (int j = 0; j < COLUMNS; j++) f->full[3 * COLUMNS + j] = 0; /* a row without entries */
  for (int j = 0; j < COLUMNS; j++) f->x[j] = seed_uniform(&seed, -1, 1);
  for (int j = 0; j < COLUMNS; j++) f->c[j] = seed_uniform(&seed, -1, 1);
  for (int i = 0; i < ROWS; i++) f->b[i] = seed_uniform(&seed, -1, 1);
  for (int i = 0; i < ROWS; i++) f->y[i] = seed_uniform(&seed, -1, 1);
  f->a = dense_to_csr(f->full, ROWS, COLUMNS);
  *state = f;
  return 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  sct_csr_free(&f->a);
  free(f);
  return 0;
}

static void multiplies(void **state) {
  fixture *f = *state;
  double y[ROWS], z[ROWS], w[COLUMNS];
  sct_csr_multiply(f->a, f->x, y);
  memcpy(w, f->c, sizeof w);
  sct_csr_multiply_transposed_add(f->a, -2.5, f->y, w);
  for (int j = 0; j < COLUMNS; j++) {
    double sum = f->c[j];
    for (int i = 0; i < ROWS; i++) sum -= 2.5 * f->full[i * COLUMNS + j] * f->y[i];
    assert_near(w[j], sum, 1e-14);
  }
  memcpy(z, f->b, sizeof z);
  sct_csr_multiply_add(f->a, -2.5, f->x, z);
  for (int i = 0; i < ROWS; i++) {
    double sum = 0;
    for (int j = 0; j < COLUMNS; j++) sum += f->full[i * COLUMNS + j] * f->x[j];
    assert_near(y[i], sum, 1e-15);
    assert_near(z[i], f->b[i] - 2.5 * sum, 1e-14);
  }
  assert_true(y[3] == 0);
}

static void residual_and_its_scale(void **state) {
  fixture *f = *state;
  double r[ROWS], again[ROWS], scale[ROWS];
  sct_csr_residual(f->a, f->x, f->b, r, scale);
  sct_csr_residual(f->a, f->x, f->b, again, NULL);
  for (int i = 0; i < ROWS; i++) {
    double sum = f->b[i], size = fabs(f->b[i]);
    for (int j = 0; j < COLUMNS; j++) {
      sum -= f->full[i * COLUMNS + j] * f->x[j];
      size += fabs(f->full[i * COLUMNS + j] * f->x[j]);
    }
    assert_near(r[i], sum, 1e-14);
    assert_near(scale[i], size, 1e-14);
    assert_true(again[i] == r[i]);
  }
}

static void residual_of_the_transpose(void **state) {
  fixture *f = *state;
  double r[COLUMNS], again[COLUMNS], scale[COLUMNS];
  sct_csr_residual_transposed(f->a, f->y, f->c, r, scale);
  sct_csr_residual_transposed(f->a, f->y, f->c, again, NULL);
  for (int j = 0; j < COLUMNS; j++) {
    double sum = f->c[j], size = fabs(f->c[j]);
    for (int i = 0; i < ROWS; i++) {
      sum -= f->full[i * COLUMNS + j] * f->y[i];
      size += fabs(f->full[i * COLUMNS + j] * f->y[i]);
    }
    assert_near(r[j], sum, 1e-14);
    assert_near(scale[j], size, 1e-14);
    assert_true(again[j] == r[j]);
  }
}

static void new_is_empty_and_free_clears(void **state) {
  (void)state;
  sct_csr *a = NULL;
  assert_int_equal(sct_csr_new(4, 3, 6, &a, NULL), SCT_OK);
  assert_int_equal(a->rows, 4);
  assert_int_equal(a->columns, 3);
  for (int i = 0; i <= 4; i++) assert_int_equal(a->start[i], 0);
  assert_int_equal(sct_csr_entries(a), 0);
  sct_csr_free(&a);
  assert_null(a);
  sct_csr_free(&a);
}

static void a_size_beyond_memory_is_an_error(void **state) {
  (void)state;
  sct_csr *a = (sct_csr *)&a;
  sct_error err;
  assert_int_equal(sct_csr_new(INT64_MAX / 4, 1, 1, &a, &err), SCT_E_MEMORY);
  assert_null(a);
  a = (sct_csr *)&a;
  assert_int_equal(sct_csr_new(1, 1, INT64_MAX / 2, &a, &err), SCT_E_MEMORY);
  assert_null(a);
  assert_int_equal(err.code, SCT_E_MEMORY);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(multiplies, set_up, tear_down),
      cmocka_unit_test_setup_teardown(residual_and_its_scale, set_up, tear_down),
      cmocka_unit_test_setup_teardown(residual_of_the_transpose, set_up, tear_down),
      cmocka_unit_test(new_is_empty_and_free_clears),
      cmocka_unit_test(a_size_beyond_memory_is_an_error),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
