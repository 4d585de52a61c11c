/* The only door to UMFPACK, and to the BLAS below it: multifrontal LU with dense kernels, for all
 * but the smallest systems. */
#include <cblas.h>
#include <umfpack.h>

#include "alloc.h"
#include "solve_kind.h"

/* Rows of a three-dimensional cloud from which nested dissection pays (tests/bench/bench_solve.md):
 * at 24 000 rows twice as fast as AMD in half the memory, at 1 000 half as fast. In two dimensions
 * it saves a quarter of the memory, never time, up to 250 000 rows at least. */
enum { metis_rows = 3000 };

typedef struct {
  double control[UMFPACK_CONTROL], info[UMFPACK_INFO];
  void *symbolic, *numeric;
  int *index;   /* [n] work of a solve */
  double *work; /* [n] */
} umf_state;

static const char *ordering_name(const umf_state *s) {
  static const char *const names[] = {[UMFPACK_ORDERING_CHOLMOD] = "cholmod",
                                      [UMFPACK_ORDERING_AMD] = "amd",
                                      [UMFPACK_ORDERING_METIS] = "metis"};
  const int used = (int)s->info[UMFPACK_ORDERING_USED];
  if (used == UMFPACK_ORDERING_AMD &&
      s->info[UMFPACK_STRATEGY_USED] != UMFPACK_STRATEGY_SYMMETRIC) {
    return "colamd";
  }
  return used >= 0 && used <= UMFPACK_ORDERING_METIS && names[used] != NULL ? names[used] : "other";
}

static sct_status failure(const umf_state *s, const sct_solve_matrix *a, const char *phase,
                          int code, sct_error *err) {
  if (code == UMFPACK_WARNING_singular_matrix) {
    return sct_fail(err, SCT_E_SINGULAR, -1, "zero pivot: rank %.0f of %d",
                    s->info[UMFPACK_UDIAG_NZ], a->n);
  }
  /* out of memory, or of 32-bit indices into it; an ordering that failed for the same */
  return sct_fail(err, SCT_E_MEMORY, -1,
                  "no memory in %s of umfpack: %d rows, %d entries, about %.0f MB needed", phase,
                  a->n, a->start[a->n],
                  s->info[UMFPACK_PEAK_MEMORY_ESTIMATE] * s->info[UMFPACK_SIZE_OF_UNIT] / 1e6);
}

static void release(void *state) {
  umf_state *s = state;
  if (s->numeric != NULL) umfpack_di_free_numeric(&s->numeric);
  if (s->symbolic != NULL) umfpack_di_free_symbolic(&s->symbolic);
  sct_release(&s->index);
  sct_release(&s->work);
  sct_release(&s);
}

static sct_status analyse(const sct_solve_matrix *a, const sct_solve_options *options, void **state,
                          sct_solve_report *report, sct_error *err) {
  umf_state *s = NULL;
  sct_status status = sct_alloc_zero(&s, 1, sizeof *s, err);
  if (status != SCT_OK) return status;
  status = sct_alloc(&s->index, a->n, sizeof *s->index, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc(&s->work, a->n, sizeof *s->work, err);
  if (status != SCT_OK) goto done;
  umfpack_di_defaults(s->control);
  s->control[UMFPACK_ORDERING] =
      options->dim == 3 && a->n >= metis_rows ? UMFPACK_ORDERING_METIS : UMFPACK_ORDERING_AMD;
  s->control[UMFPACK_IRSTEP] = 0; /* refinement is the front's, with A as the caller gave it */
  const int code = umfpack_di_symbolic(a->n, a->n, a->start, a->index, a->value, &s->symbolic,
                                       s->control, s->info);
  if (code != UMFPACK_OK) status = failure(s, a, "analysis", code, err);
  report->ordering = ordering_name(s);
done:
  if (status != SCT_OK) {
    release(s);
    s = NULL;
  }
  *state = s;
  return status;
}

static sct_status factor(void *state, const sct_solve_matrix *a, sct_solve_report *report,
                         sct_error *err) {
  umf_state *s = state;
  if (s->numeric != NULL) umfpack_di_free_numeric(&s->numeric);
  const int code = umfpack_di_numeric(a->start, a->index, a->value, s->symbolic, &s->numeric,
                                      s->control, s->info);
  if (code != UMFPACK_OK) return failure(s, a, "factorisation", code, err);
  report->factor_nonzeros = (int64_t)(s->info[UMFPACK_LNZ] + s->info[UMFPACK_UNZ]);
  report->peak_bytes = (int64_t)(s->info[UMFPACK_PEAK_MEMORY] * s->info[UMFPACK_SIZE_OF_UNIT]);
  return SCT_OK;
}

static sct_status solve(void *state, const sct_solve_matrix *a, const double *b, bool transposed,
                        double *x, sct_solve_report *report, sct_error *err) {
  umf_state *s = state;
  (void)report;
  const int code =
      umfpack_di_wsolve(transposed ? UMFPACK_At : UMFPACK_A, a->start, a->index, a->value, x, b,
                        s->numeric, s->control, s->info, s->index, s->work);
  return code == UMFPACK_OK ? SCT_OK : failure(s, a, "solve", code, err);
}

/* Any triangular solve makes OpenBLAS map its work space, which it never returns. */
static void prepare(void) {
  const double one = 1;
  double x = 1;
  cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasUnit, 1, 1, 1, &one, 1, &x,
              1);
}

const sct_solve_kind sct_solve_umfpack = {.name = "umfpack",
                                          .prepare = prepare,
                                          .analyse = analyse,
                                          .factor = factor,
                                          .solve = solve,
                                          .free = release};
