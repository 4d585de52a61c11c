#include "solve_by_ranks.h"

#include <stdio.h>
#include <string.h>

#include "by_ranks.h"
#include "discretisation.h"

/* Does anything hold the solution in its place? Whether that holds all of it, only the whole system
 * tells (sct_system_explain). */
static bool is_fixed(const solve *s) {
  for (int64_t i = 0; i < s->in.cloud.cloud.n; i++) {
    const int condition = s->in.boundary.condition[i];
    if (condition == SCT_DIRICHLET || condition == SCT_ROBIN) return true;
    if (s->in.reaction.value && s->in.reaction.value[i] > 0) return true;
  }
  return false;
}

const char *solve_alone(const task *t, const void *state) {
  const solve *s = state;
  const char *method = s->in.march.solve.method;
  (void)t;
  if (s->in.is_transient) return "a march in time is not run in parallel";
  if (s->in.op.upwind == SCT_UPWIND_LIMITED) return "upwind limited is not run in parallel";
  if (method && strcmp(method, "auto") && strcmp(method, "iterative")) {
    return "a direct solver was asked for";
  }
  if (!is_fixed(s)) return "nothing determines the solution but a constant";
  return NULL;
}

/* As of a solve that is not shared; every rank looks at the whole cloud for that. */
static sct_status find_spacing(task *t, const cloud_input *c, double *spacing) {
  sct_search *search = NULL;
  *spacing = c->spacing;
  if (c->spacing > 0) return SCT_OK;
  double *nearest = task_take(t, c->cloud.n, sizeof *nearest);
  if (!nearest) return t->error.code;
  sct_status status = sct_search_build(&c->cloud, 0, SCT_SEARCH_AUTO, &t->work, &search, &t->error);
  if (!status) status = discretisation_spacing(t, c, search, nearest, spacing);
  sct_search_free(&search);
  return status;
}

static sct_status solve_parts(task *t, solve *s, double spacing) {
  by_ranks *r = t->ranks;
  const cloud_input *c = &s->in.cloud;
  const sct_fields fields = solve_input_fields(&s->in);
  const sct_boundary boundary = solve_input_boundary(&s->in);
  sct_partition *partition = NULL;
  sct_solve_options options = s->in.march.solve;
  options.dim = c->cloud.dim;
  /* the places of posted points run along the curve */
  sct_status status =
      sct_partition_build(&c->cloud, r->count, !c->is_lattice, &partition, &t->error);
  if (status) return status;
  const sct_part_problem whole = {.cloud = &c->cloud,
                                  .partition = partition,
                                  .spacing = spacing,
                                  .op = &s->in.op,
                                  .limit = t->limits->neighbours,
                                  .fields = &fields,
                                  .boundary = &boundary};
  stopwatch_lap(&t->watch, LAP_SEARCH);
  status = sct_ranks_solve(r->group, &whole, &options, &t->work, s->phi, &s->solve, &r->report,
                           &t->error);
  stopwatch_lap(&t->watch, LAP_SOLVE);
  stopwatch_move(&t->watch, LAP_SOLVE, LAP_ASSEMBLE, r->report.seconds_assemble);
  stopwatch_move(&t->watch, LAP_SOLVE, LAP_FACTOR, s->solve.seconds_factor);
  sct_partition_free(&partition);
  return status;
}

/* A failure that is no lack of memory is told best by who looks at the whole: rank 0 tries alone.
 */
bool solve_by_ranks(task *t, solve *s) {
  char reason[sizeof t->ranks->alone];
  double spacing;
  sct_status status = find_spacing(t, &s->in.cloud, &spacing);
  if (!status) status = solve_parts(t, s, spacing);
  if (status == SCT_E_MEMORY) return false;
  if (!status) return by_ranks_disband(t, NULL);
  snprintf(reason, sizeof reason, "in parallel: %.200s", t->error.text);
  t->error = (sct_error){.code = SCT_OK};
  (void)by_ranks_disband(t, reason);
  return false;
}
