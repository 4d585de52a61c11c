/* With dx, df the differences of successive x and f, gamma = argmin |f - sum_c gamma_c df_c|,
 *   x <- x + f - sum_c gamma_c (dx_c + df_c).
 * Least squares by Gram-Schmidt, the newest difference first: what the older ones add to the space
 * gets ever smaller, and those that rounding has taken over are left out. */
#include "anderson.h"

#include <math.h>
#include <string.h>

#include "alloc.h"

/* What must be left of a difference after the newer ones are taken out of it. */
static const double INDEPENDENT = 1e-3;

struct sct_anderson {
  int64_t n;
  int held, newest;                /* differences; place of the newest */
  bool moved;                      /* x, f hold the step before */
  double *x, *f;                   /* [n] */
  double *dx[SCT_ANDERSON_WINDOW]; /* [n] */
  double *df[SCT_ANDERSON_WINDOW]; /* [n] */
  double *q[SCT_ANDERSON_WINDOW];  /* [n] orthonormal, newest first */
};

sct_status sct_anderson_new(int64_t n, sct_anderson **out, sct_error *err) {
  sct_anderson *a = NULL;
  sct_status status = sct_alloc_zero(&a, 1, sizeof *a, err);
  if (status == SCT_OK) a->n = n;
  if (status == SCT_OK) status = sct_alloc(&a->x, n, sizeof *a->x, err);
  if (status == SCT_OK) status = sct_alloc(&a->f, n, sizeof *a->f, err);
  for (int c = 0; status == SCT_OK && c < SCT_ANDERSON_WINDOW; c++) {
    status = sct_alloc(&a->dx[c], n, sizeof(double), err);
    if (status == SCT_OK) status = sct_alloc(&a->df[c], n, sizeof(double), err);
    if (status == SCT_OK) status = sct_alloc(&a->q[c], n, sizeof(double), err);
  }
  if (status != SCT_OK) sct_anderson_free(&a);
  *out = a;
  return status;
}

void sct_anderson_free(sct_anderson **anderson) {
  sct_anderson *a = *anderson;
  if (a == NULL) return;
  for (int c = 0; c < SCT_ANDERSON_WINDOW; c++) {
    sct_release(&a->dx[c]);
    sct_release(&a->df[c]);
    sct_release(&a->q[c]);
  }
  sct_release(&a->x);
  sct_release(&a->f);
  sct_release(anderson);
}

void sct_anderson_restart(sct_anderson *a) {
  a->held = 0;
  a->moved = false;
}

static double dot(int64_t n, const double *a, const double *b) {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (int64_t k = 0; k < n; k++) sum += a[k] * b[k];
  return sum;
}

/* a = a + s b */
static void add(int64_t n, double s, const double *b, double *a) {
  for (int64_t k = 0; k < n; k++) a[k] += s * b[k];
}

static void remember(sct_anderson *a, const double *f, const double *x) {
  if (a->moved) {
    a->newest = (a->newest + 1) % SCT_ANDERSON_WINDOW;
    if (a->held < SCT_ANDERSON_WINDOW) a->held++;
    double *dx = a->dx[a->newest], *df = a->df[a->newest];
    for (int64_t k = 0; k < a->n; k++) {
      dx[k] = x[k] - a->x[k];
      df[k] = f[k] - a->f[k];
    }
  }
  memcpy(a->x, x, (size_t)a->n * sizeof *x);
  memcpy(a->f, f, (size_t)a->n * sizeof *f);
  a->moved = true;
}

/* Place of difference c, the newest being 0. */
static int place(const sct_anderson *a, int c) {
  return (a->newest - c + SCT_ANDERSON_WINDOW) % SCT_ANDERSON_WINDOW;
}

/* Q R = df, newest first; returns how many are independent. */
static int orthogonalise(const sct_anderson *a,
                         double r[SCT_ANDERSON_WINDOW][SCT_ANDERSON_WINDOW]) {
  for (int c = 0; c < a->held; c++) {
    double *q = a->q[c];
    memcpy(q, a->df[place(a, c)], (size_t)a->n * sizeof *q);
    const double whole = sqrt(dot(a->n, q, q));
    for (int b = 0; b < c; b++) {
      r[b][c] = dot(a->n, a->q[b], q);
      add(a->n, -r[b][c], a->q[b], q);
    }
    r[c][c] = sqrt(dot(a->n, q, q));
    if (!(r[c][c] > INDEPENDENT * whole)) return c;
    for (int64_t k = 0; k < a->n; k++) q[k] /= r[c][c];
  }
  return a->held;
}

void sct_anderson_step(sct_anderson *a, const double *f, double *x) {
  double r[SCT_ANDERSON_WINDOW][SCT_ANDERSON_WINDOW] = {{0}}, gamma[SCT_ANDERSON_WINDOW] = {0};
  remember(a, f, x);
  const int count = orthogonalise(a, r);
  add(a->n, 1, f, x);
  for (int c = count - 1; c >= 0; c--) { /* R gamma = Q^T f */
    gamma[c] = dot(a->n, a->q[c], f);
    for (int b = c + 1; b < count; b++) gamma[c] -= r[c][b] * gamma[b];
    gamma[c] /= r[c][c];
  }
  for (int c = 0; c < count; c++) {
    add(a->n, -gamma[c], a->dx[place(a, c)], x);
    add(a->n, -gamma[c], a->df[place(a, c)], x);
  }
}
