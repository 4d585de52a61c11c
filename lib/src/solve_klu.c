/* The only door to KLU: for matrices so sparse that dense kernels do not pay (small ones, and those
 * of one dimension). Block triangular form, AMD within the blocks, column by column elimination. */
#include <klu.h>
#include <string.h>

#include "alloc.h"
#include "solve_kind.h"

typedef struct {
  klu_common common;
  klu_symbolic *symbolic;
  klu_numeric *numeric;
} klu_state;

static sct_status failure(const klu_state *s, const sct_solve_matrix *a, const char *phase,
                          sct_error *err) {
  if (s->common.status == KLU_SINGULAR) {
    return sct_fail(err, SCT_E_SINGULAR, -1, "zero pivot: rank %d or less of %d",
                    s->common.numerical_rank, a->n);
  }
  /* KLU_OUT_OF_MEMORY, KLU_TOO_LARGE */
  return sct_fail(err, SCT_E_MEMORY, -1,
                  "no memory in %s of klu: %d rows, %d entries, %zu bytes used", phase, a->n,
                  a->start[a->n], s->common.mempeak);
}

static void release(void *state) {
  klu_state *s = state;
  klu_free_numeric(&s->numeric, &s->common);
  klu_free_symbolic(&s->symbolic, &s->common);
  sct_release(&s);
}

static sct_status analyse(const sct_solve_matrix *a, const sct_solve_options *options, void **state,
                          sct_solve_report *report, sct_error *err) {
  (void)options;
  klu_state *s = NULL;
  sct_status status = sct_alloc_zero(&s, 1, sizeof *s, err);
  if (status != SCT_OK) return status;
  klu_defaults(&s->common);
  s->symbolic = klu_analyze(a->n, a->start, a->row, &s->common);
  if (s->symbolic == NULL) {
    status = failure(s, a, "analysis", err);
  } else if (s->symbolic->structural_rank < a->n) {
    status = sct_fail(err, SCT_E_SINGULAR, -1, "the pattern has rank %d, the matrix %d rows",
                      s->symbolic->structural_rank, a->n);
  }
  if (status != SCT_OK) {
    release(s);
    s = NULL;
  }
  report->ordering = "amd";
  *state = s;
  return status;
}

static sct_status factor(void *state, const sct_solve_matrix *a, sct_solve_report *report,
                         sct_error *err) {
  klu_state *s = state;
  klu_free_numeric(&s->numeric, &s->common);
  s->numeric = klu_factor(a->start, a->row, a->value, s->symbolic, &s->common);
  if (s->numeric == NULL) return failure(s, a, "factorisation", err);
  report->factor_nonzeros = (int64_t)s->numeric->lnz + s->numeric->unz + s->numeric->nzoff;
  report->peak_bytes = (int64_t)s->common.mempeak;
  return SCT_OK;
}

static sct_status solve(void *state, const sct_solve_matrix *a, const double *b, bool transposed,
                        double *x, sct_solve_report *report, sct_error *err) {
  klu_state *s = state;
  (void)report;
  memcpy(x, b, (size_t)a->n * sizeof *x);
  const int ok = transposed ? klu_tsolve(s->symbolic, s->numeric, a->n, 1, x, &s->common)
                            : klu_solve(s->symbolic, s->numeric, a->n, 1, x, &s->common);
  return ok ? SCT_OK : failure(s, a, "solve", err);
}

const sct_solve_kind sct_solve_klu = {
    .name = "klu", .analyse = analyse, .factor = factor, .solve = solve, .free = release};
