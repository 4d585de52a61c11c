#include "discretisation.h"

#include <math.h>

/* Rows are made of squares of distances and of weights over them: both must be numbers. */
static const double least_spacing = 1e-150, most_spacing = 1e150;

static sct_status check_scale(task *t, const double *nearest, int64_t n, double spacing) {
  if (!(spacing >= least_spacing && spacing <= most_spacing)) {
    return sct_fail(&t->error, SCT_E_ARGUMENT, 0, "is in a cloud of spacing %g, needs %g to %g",
                    spacing, least_spacing, most_spacing);
  }
  for (int64_t i = 0; i < n; i++) {
    if (isfinite(spacing / nearest[i] / nearest[i] / nearest[i]))
      continue; /* the steepest kernel */
    return sct_fail(&t->error, SCT_E_ARGUMENT, i,
                    "is %g away from another point, too near for a spacing of %g", nearest[i],
                    spacing);
  }
  return SCT_OK;
}

sct_status discretisation_spacing(task *t, const cloud_input *c, const sct_search *search,
                                  double *nearest, double *spacing) {
  double median = 0;
  if (sct_search_nearest(search, &t->work, nearest, &t->error)) return t->error.code;
  if (sct_median(nearest, c->cloud.n, &median, &t->error)) return t->error.code;
  *spacing = c->spacing > 0 ? c->spacing : median;
  if (!isfinite(*spacing)) {
    return sct_fail(&t->error, SCT_E_DEFICIENT, 0, "is alone, needs another point or a spacing");
  }
  return check_scale(t, nearest, c->cloud.n, *spacing);
}

sct_status discretisation_build(task *t, const cloud_input *c, const sct_operator *op,
                                discretisation *d) {
  sct_status status = sct_work_report(&t->work, "search", 0, &t->error);
  if (status) return status;
  d->nearest = task_take(t, c->cloud.n, sizeof *d->nearest);
  status = t->error.code;
  if (status) return status;
  status = sct_search_build(&c->cloud, c->spacing * op->radius, SCT_SEARCH_AUTO, &t->work,
                            &d->search, &t->error);
  if (status) return status;
  status = discretisation_spacing(t, c, d->search, d->nearest, &d->spacing);
  stopwatch_lap(&t->watch, LAP_SEARCH);
  if (status) return status;
  status = sct_work_report(&t->work, "stencil", 0, &t->error);
  if (status) return status;
  status = sct_stencil_build(&c->cloud, d->search, d->spacing, op, t->limits->neighbours, &t->work,
                             &d->stencil, &t->error);
  stopwatch_lap(&t->watch, LAP_STENCIL);
  return status;
}

void discretisation_clear(discretisation *d) {
  sct_stencil_free(&d->stencil);
  sct_search_free(&d->search);
}
