/* diagnostics.h - the outputs `diagnostics` and `summary`: what cloud, operator and solver have to
 * tell. Statistics of the cloud are over the points of `mask`, those that carry the equation.
 */
#ifndef SCATTERD_DIAGNOSTICS_H
#define SCATTERD_DIAGNOSTICS_H

#include "discretisation.h"
#include "emit.h"
#include "scatter/diagnose.h"
#include "scatter/march.h"

enum { TENSOR_MAX = SCT_DIM_MAX * (SCT_DIM_MAX + 1) / 2, DEFICIENT_MAX = 20 };

typedef struct {
  int dim;
  double h;          /* spacing that operators are made with (length) */
  double median;     /* of the distance to the nearest point (length) */
  sct_range spacing; /* of that distance */
  sct_range neighbours;
  double velocity_rms[SCT_DIM_MAX], velocity_max; /* artificial velocity (1 / length) */
  double tensor_mean[TENSOR_MAX], tensor_deviation[TENSOR_MAX];
  int64_t deficient; /* points with too few or degenerate neighbours, and the first of them */
  int32_t deficient_points[DEFICIENT_MAX];
  bool has_rows; /* widened and fallback are there: an apply says them so, a solve by is_solve */
  /* points whose rows have a support wider, or another scheme, than asked for; weights so so */
  int64_t widened, fallback, loose;
  /* of a solve */
  bool is_solve, is_limited;
  int64_t rows, nonzeros;         /* of its matrix */
  double peclet_mean, peclet_max; /* |u| h / mu; NaN: not defined */
  sct_range bounds;               /* of the solution */
  sct_solve_report solve;         /* method NULL: nothing was factored */
  bool is_transient;
  sct_march_report march;
} diagnostics;

/* Point by point, by place: what sct_diagnose can tell, in memory of the task. False when out of
 * memory. */
bool diagnosis_take(task *t, const cloud_input *c, sct_diagnosis *all);

/* The part about cloud and operator. mask [n] by place, NULL: all. Failures are in t->error. */
sct_status diagnostics_of_cloud(task *t, const cloud_input *c, const discretisation *d,
                                const sct_diagnosis *all, const uint8_t *mask, diagnostics *out);

/* Counts what became of the rows: flags [n] of SCT_ROW_*. */
void diagnostics_of_rows(const uint8_t *flags, int64_t n, diagnostics *out);

/* Cell Peclet numbers: velocity [n][dim] (NULL: 0), diffusivity [n]. */
void diagnostics_of_fields(const double *velocity, const double *diffusivity, int64_t n,
                           const uint8_t *mask, diagnostics *out);

/* Size and rows of a system. */
void diagnostics_of_system(const sct_system *system, diagnostics *out);

void diagnostics_write(emit *e, const diagnostics *d);

/* {"l1","l2","linf","l2_relative","linf_all","points"} */
void emit_norms(emit *e, const sct_norms *norms);

#endif
