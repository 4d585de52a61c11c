/* The only door to CHOLMOD. */
#include "solve_cholmod.h"

#include <cholmod.h>
#include <string.h>

#include "alloc.h"

struct sct_cholesky {
  cholmod_common common;
  cholmod_factor *factor;
  cholmod_dense *b, *x, *y, *e; /* right-hand side, solution and work of cholmod_solve2 */
};

static sct_status failure(const sct_cholesky *c, const char *phase, sct_error *err) {
  if (c->common.status == CHOLMOD_NOT_POSDEF) {
    return sct_fail(err, SCT_E_SINGULAR, -1, "the matrix is not positive definite");
  }
  return sct_fail(err, SCT_E_MEMORY, -1, "no memory in %s of cholmod", phase);
}

/* A row of the lower triangle is a column of the upper one. */
static cholmod_sparse *upper_triangle(sct_cholesky *c, const sct_csr *a) {
  size_t entries = 0;
  for (int64_t i = 0; i < a->rows; i++) {
    for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) entries += a->column[k] <= i;
  }
  cholmod_sparse *s = cholmod_allocate_sparse((size_t)a->rows, (size_t)a->rows, entries, 1, 1, 1,
                                              CHOLMOD_REAL, &c->common);
  if (s == NULL) return NULL;
  int *start = s->p, *row = s->i, n = 0;
  double *value = s->x;
  for (int64_t i = 0; i < a->rows; i++) {
    start[i] = n;
    for (int64_t k = a->start[i]; k < a->start[i + 1] && a->column[k] <= i; k++, n++) {
      row[n] = a->column[k];
      value[n] = a->value[k];
    }
  }
  start[a->rows] = n;
  return s;
}

sct_status sct_cholesky_build(const sct_csr *a, sct_cholesky **out, sct_error *err) {
  sct_cholesky *c = NULL;
  cholmod_sparse *s = NULL;
  *out = NULL;
  sct_status status = sct_alloc_zero(&c, 1, sizeof *c, err);
  if (status != SCT_OK) return status;
  cholmod_start(&c->common);
  c->common.supernodal = CHOLMOD_SIMPLICIAL;
  c->common.final_ll = 1;
  c->common.print = 0;
  s = upper_triangle(c, a);
  if (s != NULL) c->factor = cholmod_analyze(s, &c->common);
  if (c->factor != NULL) (void)cholmod_factorize(s, c->factor, &c->common);
  if (c->factor == NULL || c->common.status != CHOLMOD_OK) {
    status = failure(c, "factorisation", err);
    goto done;
  }
  c->b = cholmod_allocate_dense((size_t)a->rows, 1, (size_t)a->rows, CHOLMOD_REAL, &c->common);
  if (c->b == NULL) status = failure(c, "factorisation", err);
done:
  cholmod_free_sparse(&s, &c->common);
  if (status != SCT_OK) sct_cholesky_free(&c);
  *out = c;
  return status;
}

sct_status sct_cholesky_solve(sct_cholesky *c, const double *b, double *x, sct_error *err) {
  const size_t bytes = c->b->nrow * sizeof *b;
  memcpy(c->b->x, b, bytes);
  const int good =
      cholmod_solve2(CHOLMOD_A, c->factor, c->b, NULL, &c->x, NULL, &c->y, &c->e, &c->common);
  if (!good) return failure(c, "solve", err);
  memcpy(x, c->x->x, bytes);
  return SCT_OK;
}

void sct_cholesky_free(sct_cholesky **c) {
  if (*c == NULL) return;
  cholmod_common *common = &(*c)->common;
  cholmod_free_dense(&(*c)->b, common);
  cholmod_free_dense(&(*c)->x, common);
  cholmod_free_dense(&(*c)->y, common);
  cholmod_free_dense(&(*c)->e, common);
  cholmod_free_factor(&(*c)->factor, common);
  cholmod_finish(common);
  sct_release(c);
}
