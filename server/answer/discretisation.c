#include "discretisation.h"

#include <math.h>

static sct_status find_spacing(task *t, const cloud_input *c, discretisation *d) {
  double median = 0;
  if (sct_search_nearest(d->search, &t->work, d->nearest, &t->error)) return t->error.code;
  if (sct_median(d->nearest, c->cloud.n, &median, &t->error)) return t->error.code;
  d->spacing = c->spacing > 0 ? c->spacing : median;
  if (isfinite(d->spacing)) return SCT_OK;
  return sct_fail(&t->error, SCT_E_DEFICIENT, 0, "is alone, needs another point or a spacing");
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
  status = find_spacing(t, c, d);
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
