/* row_lsmps.c - weighted least squares fit of a Taylor polynomial without constant.
 *
 * Minimise sum_k W_k (phi_k - phi_i - sum_m p_m(s_k) a_m)^2, s = r / r_e, p_m the monomials of
 * degree 1 .. degree. With A = W^(1/2) p(s) = Q R P^T (column-pivoted) a derivative, which is
 * e . a for some e, has the weights W^(1/2) Q R^-T P^T e. Normal equations would square the
 * condition number; Gram-Schmidt in its modified form leaves Q ready for use, and loses
 * orthogonality only in proportion to the condition number, which is bounded here.
 */
#include <math.h>

#include "row.h"
#include "vector.h"

typedef struct {
  int unknowns;
  int pivot[SCT_UNKNOWNS_MAX];                  /* column t of Q R is monomial pivot[t] */
  double r[SCT_UNKNOWNS_MAX][SCT_UNKNOWNS_MAX]; /* R by rows */
  double scale;                                 /* largest column norm */
  double ill;                                   /* largest condition number accepted */
} fit;

/* Largest condition number accepted, by degree. Inside a cloud it is 2 to 5, 6 to 18, 10 to 90; on
 * the boundary, where a fit is one-sided, twice to ten times that, and wider supports bring it
 * down. What is solved with is judged by its weights and only kept from rounding here. */
static const double ILL[] = {[2] = 12, [3] = 50, [4] = 300};
static const double ILL_TO_SOLVE = 10; /* times that */

/* Largest sum |l| / sum l accepted to solve with: an M-matrix has 1. */
static const double UNSTABLE = 1.5;

/* Largest sum |c| / |sum c| accepted of a normal derivative, by degree, in 2-D; three tenths more
 * or less by dimension. In 1-D the one-sided differences (-3, 4, -1)/2, (-11, 18, -9, 2)/6,
 * (-25, 48, -36, 16, -3)/12 have 1.7, 2.6, 4.1; the sides of a lattice 2.9, 4.5, 7.1 in 2-D and
 * 3.6, 6.0, 9.4 in 3-D on the narrowest support that has enough layers. A fit beyond carries the
 * disorder of the cloud into the solution (verify.assemble, mixed boundaries). */
static const double STEEP[] = {[2] = 3.0, [3] = 4.6, [4] = 7.3};

static double steep(const row_job *job) {
  return STEEP[job->degree] * (0.4 + 0.3 * job->dim);
}

int row_unknowns(int dim, int degree) {
  int count = 1; /* (dim + degree)! / (dim! degree!) - 1 */
  for (int k = 1; k <= dim; k++) count = count * (degree + k) / k;
  return count - 1;
}

static double *column(const row_job *job, int m) {
  return job->room->fit + m * job->n;
}

/* Column m of A is a column of one degree less times a coordinate. Monomials are made degree by
 * degree; within a degree those that end in coordinate a follow each other: a monomial may only be
 * multiplied by its last coordinate or a later one, so each is made once. */
SCT_VECTOR static void monomials(const row_job *job) {
  const sct_room *room = job->room;
  int last[SCT_UNKNOWNS_MAX], count = 0, first = 0;
  const double scale = 1 / job->support;
  for (int a = 0; a < job->dim; a++, count++) {
    double *to = column(job, count);
    last[count] = a;
    for (int64_t k = 0; k < job->n; k++) to[k] = room->scratch[k] * room->r[a][k] * scale;
  }
  for (int degree = 2; degree <= job->degree; degree++) {
    const int end = count;
    for (int m = first; m < end; m++) {
      for (int a = last[m]; a < job->dim; a++, count++) {
        const double *from = column(job, m), *r = room->r[a];
        double *to = column(job, count);
        last[count] = a;
        for (int64_t k = 0; k < job->n; k++) to[k] = from[k] * r[k] * scale;
      }
    }
    first = end;
  }
}

/* Monomial r_a^2 in the order above: 1-D xx; 2-D xx xy yy; 3-D xx xy xz yy yz zz. */
static int square_of(int dim, int a) {
  static const int at[SCT_DIM_MAX][SCT_DIM_MAX] = {{1}, {2, 4}, {3, 6, 8}};
  return at[dim - 1][a];
}

/* room->scratch = W^(1/2) */
static void root_weight(const row_job *job) {
  const sct_room *room = job->room;
  const double *weight = job->weight == SCT_WEIGHT_KERNEL ? room->w : room->f;
  for (int64_t k = 0; k < job->n; k++) room->scratch[k] = sqrt(weight[k]);
}

/* row_sum2, to be inlined into the wide versions of what calls it. */
static inline double dot(int64_t n, const double *restrict a, const double *restrict b) {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (int64_t k = 0; k < n; k++) sum += a[k] * b[k];
  return sum;
}

/* a = a - s q; returns the new |a|^2 */
static inline double subtract(int64_t n, double s, const double *restrict q, double *restrict a) {
  double norm2 = 0;
#pragma omp simd reduction(+ : norm2)
  for (int64_t k = 0; k < n; k++) {
    a[k] -= s * q[k];
    norm2 += a[k] * a[k];
  }
  return norm2;
}

static void swap_columns(const row_job *job, fit *f, double *norm2, int s, int t) {
  if (s == t) return;
  double *a = column(job, s), *b = column(job, t);
  for (int64_t k = 0; k < job->n; k++) {
    const double keep = a[k];
    a[k] = b[k];
    b[k] = keep;
  }
  for (int row = 0; row < s; row++) {
    const double keep = f->r[row][s];
    f->r[row][s] = f->r[row][t];
    f->r[row][t] = keep;
  }
  const int keep = f->pivot[s];
  f->pivot[s] = f->pivot[t];
  f->pivot[t] = keep;
  norm2[t] = norm2[s]; /* norm2[s] is used up */
}

static int largest(const double *value, int from, int end) {
  int best = from;
  for (int t = from + 1; t < end; t++) {
    if (value[t] > value[best]) best = t;
  }
  return best;
}

/* Q R P^T = A, Q in place. |R_00 / R_tt| estimates the condition number from below. */
SCT_VECTOR static bool factor(const row_job *job, fit *f) {
  double norm2[SCT_UNKNOWNS_MAX];
  for (int t = 0; t < f->unknowns; t++) {
    f->pivot[t] = t;
    norm2[t] = dot(job->n, column(job, t), column(job, t));
  }
  for (int s = 0; s < f->unknowns; s++) {
    const int best = largest(norm2, s, f->unknowns);
    const double norm = sqrt(norm2[best]);
    if (s == 0) f->scale = norm;
    if (!(norm * f->ill > f->scale)) return false;
    swap_columns(job, f, norm2, s, best);
    double *q = column(job, s);
    f->r[s][s] = norm;
    for (int64_t k = 0; k < job->n; k++) q[k] /= norm;
    for (int t = s + 1; t < f->unknowns; t++) { /* R_st = q_s . a_t, a_t = a_t - R_st q_s */
      f->r[s][t] = dot(job->n, q, column(job, t));
      norm2[t] = subtract(job->n, f->r[s][t], q, column(job, t));
    }
  }
  return true;
}

/* weight_k = W_k^(1/2) sum_t Q_kt y_t with R^T y = P^T e */
SCT_VECTOR static void functional(const row_job *job, const fit *f, const double *e,
                                  double *weight) {
  double y[SCT_UNKNOWNS_MAX];
  for (int t = 0; t < f->unknowns; t++) {
    y[t] = e[f->pivot[t]];
    for (int s = 0; s < t; s++) y[t] -= f->r[s][t] * y[s];
    y[t] /= f->r[t][t];
  }
  for (int64_t k = 0; k < job->n; k++) weight[k] = 0;
  for (int t = 0; t < f->unknowns; t++) {
    const double *q = column(job, t), yt = y[t];
    for (int64_t k = 0; k < job->n; k++) weight[k] += yt * q[k];
  }
  for (int64_t k = 0; k < job->n; k++) weight[k] *= job->room->scratch[k];
}

static void fit_gradient(const row_job *job, const fit *f) {
  for (int a = 0; a < job->dim; a++) {
    double e[SCT_UNKNOWNS_MAX] = {0};
    e[a] = 1 / job->support;
    functional(job, f, e, job->room->gradient + a * job->n);
  }
}

/* Are weights c whose sum should have the given sign good to solve with? */
static row_verdict judge(row_job *job, const double *c, double sign, double usual) {
  double sum = 0, size = 0;
  for (int64_t k = 0; k < job->n; k++) {
    sum += c[k];
    size += fabs(c[k]);
  }
  const double excess = sum * sign > 0 ? size / fabs(sum) : INFINITY;
  job->excess = excess <= usual ? 0 : excess;
  return job->excess <= job->tolerated ? ROW_ACCEPTED : ROW_UNSTABLE;
}

/* The trace of the second derivatives: 2 a_xx / r_e^2 + ... */
static row_verdict fit_laplacian(row_job *job, const fit *f) {
  double e[SCT_UNKNOWNS_MAX] = {0};
  for (int a = 0; a < job->dim; a++) {
    e[square_of(job->dim, a)] = 2 / (job->support * job->support);
  }
  functional(job, f, e, job->room->laplacian);
  return job->want & SCT_ROW_SOLVE ? judge(job, job->room->laplacian, 1, UNSTABLE) : ROW_ACCEPTED;
}

/* n . grad: outward, so the weights of the neighbours, which lie inwards, sum to less than 0. */
static row_verdict fit_normal(row_job *job, const fit *f) {
  double e[SCT_UNKNOWNS_MAX] = {0};
  for (int a = 0; a < job->dim; a++) e[a] = job->request->normal[a] / job->support;
  functional(job, f, e, job->room->laplacian);
  return judge(job, job->room->laplacian, -1, steep(job));
}

row_verdict row_lsmps(row_job *job) {
  const bool to_solve = (job->want & (SCT_ROW_SOLVE | SCT_ROW_NORMAL)) != 0;
  const bool upwind = job->velocity != NULL && (job->want & SCT_ROW_GRADIENT);
  fit f = {.unknowns = row_unknowns(job->dim, job->degree),
           .ill = ILL[job->degree] * (to_solve ? ILL_TO_SOLVE : 1)};
  row_verdict verdict = ROW_ACCEPTED;
  const bool bounded = job->op->upwind == SCT_UPWIND_LIMITED;
  if ((job->want & SCT_ROW_NORMAL) && bounded) return row_normal_linear(job);
  if (job->n <= f.unknowns) return ROW_TOO_FEW;
  if (!upwind || (job->want & SCT_ROW_LAPLACIAN)) {
    root_weight(job);
    monomials(job);
    if (!factor(job, &f)) return ROW_ILL;
    if (job->want & SCT_ROW_NORMAL) verdict = fit_normal(job, &f);
    if (job->want & SCT_ROW_LAPLACIAN) verdict = fit_laplacian(job, &f);
    if (!upwind && (job->want & SCT_ROW_GRADIENT)) fit_gradient(job, &f);
  }
  if (verdict == ROW_ACCEPTED && upwind) verdict = row_gradient_linear(job);
  return verdict;
}
