/* row.h - inside of the stencils: a neighbourhood laid out for arithmetic, and the schemes that
 * make rows of it. Shared by stencil.c and the scheme files row_*.c. */
#ifndef SCATTER_ROW_H
#define SCATTER_ROW_H

#include "scatter/stencil.h"

enum { SCT_UNKNOWNS_MAX = 34 }; /* lsmps of degree 4 in 3-D */

/* Why a neighbourhood does not carry a row. */
typedef enum {
  ROW_ACCEPTED,
  ROW_TOO_FEW,      /* neighbours */
  ROW_FLAT,         /* they do not span the space */
  ROW_ILL,          /* the fit is ill-conditioned */
  ROW_UNSTABLE,     /* the Laplacian's weights are no good to solve with */
  ROW_NO_DIFFUSION, /* the ips correction cancels the Laplacian (a one-sided neighbourhood) */
  ROW_CROWDED,      /* a wider support would hold more neighbours than the limit */
  ROW_VERDICTS
} row_verdict;

/* Scratch of one thread; arrays of `capacity` items, coordinates by component so that sums over
 * neighbours vectorise. */
struct sct_room {
  int dim;
  int columns; /* of `fit` */
  int64_t capacity;
  double *block;          /* owns all arrays of doubles below */
  double *r[SCT_DIM_MAX]; /* r_j = x_j - x_i */
  double *r2;             /* |r_j|^2 */
  double *w;              /* w(r / r_e) */
  double *f;              /* w / r^2 */
  double *scratch;        /* q, W of an upwind gradient, or W^(1/2) of a fit */
  double *laplacian;
  double *gradient; /* [dim][n] */
  double *fit;      /* [columns][n], least squares */
  int32_t *index;   /* neighbours of a widened support */
};

/* A neighbourhood and what a scheme needs to know of the stencil. */
typedef struct {
  const sct_operator *op;
  int dim, degree;
  sct_weight weight; /* of a fit */
  double tolerated;  /* largest excess of weights to solve with; 0: the usual one */
  double excess;     /* out: sum |c| / |sum c| of the fit just made; 0 if within the usual bound,
                        infinity if the sum has the wrong sign */
  int64_t n;
  double spacing, support; /* h, r_e */
  double sum_w;            /* S_w, local or reference */
  double sum_w_r2;         /* lambda S_w, local or reference */
  const sct_row_request *request;
  int want;               /* request->want */
  const double *velocity; /* [dim] or NULL: gradient is central */
  sct_room *room;
} row_job;

/* Makes what job->want asks for in room->gradient and room->laplacian. */
typedef row_verdict row_maker(row_job *job);
row_maker row_mps, row_ps, row_ips, row_ipsn, row_lsmps;

/* Gradient of first degree: g = M^-1 W r_j / r^2, upwinded if the job says so. Used by every scheme
 * with a matrix. */
row_verdict row_gradient_linear(row_job *job);

/* Gradient of a linear fit with a free constant, g = M_c^-1 w (r_j - c) / r^2 about the neighbours'
 * weighted centre c: sum_j g_ij = 0, what `limited` needs of its edges. */
row_verdict row_gradient_balanced(row_job *job);

/* Is the gradient asked for that of the edges of `limited`? */
bool row_is_limited(const row_job *job);

/* Normal derivative of first degree into room->laplacian: c = n . M^-1 w r_j / r^2. */
row_verdict row_normal_linear(row_job *job);

/* Kernel of the gradient by the job's upwinding, as weight[k] = W_k / r_k^2. */
void row_upwind_weight(const row_job *job, double *weight);

/* sum_k a_k, sum_k a_k b_k and sum_k a_k b_k c_k over n neighbours. */
double row_sum(int64_t n, const double *a);
double row_sum2(int64_t n, const double *a, const double *b);
double row_sum3(int64_t n, const double *a, const double *b, const double *c);

/* M_ab = sum_k f_k r_a r_b. */
void row_moments(const row_job *job, const double *f, double m[SCT_DIM_MAX][SCT_DIM_MAX]);

/* Inverse of a symmetric positive matrix by Cholesky; false if a pivot is below 1e-4 of the
 * trace. */
bool row_invert(int dim, double m[SCT_DIM_MAX][SCT_DIM_MAX],
                double inverse[SCT_DIM_MAX][SCT_DIM_MAX]);

/* Taylor unknowns of a degree, without the constant: 2, 5, 9 for degree 2 in 1, 2, 3 dimensions. */
int row_unknowns(int dim, int degree);

#endif
