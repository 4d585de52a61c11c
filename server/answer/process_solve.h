/* process_solve.h - the state of process `solve`, for who wants more of a solve than its outputs:
 * the system, the factors and the levels of the march are still there when it is done.
 */
#ifndef SCATTERD_PROCESS_SOLVE_H
#define SCATTERD_PROCESS_SOLVE_H

#include "diagnostics.h"
#include "process.h"
#include "solve_input.h"

typedef struct {
  solve_input in;
  discretisation grid;
  sct_system *system;
  sct_solver *solver; /* steady: factored */
  double *phi;        /* [n] the solution, by place */
  uint8_t *mask;      /* [n] points that carry the equation, by place; NULL: none do, count all */
  /* results, by the client's numbers */
  double *solution;
  sct_norms norms;
  diagnostics diagnostics;
  sct_solve_report solve;
  sct_march_report march;
  /* history, [saves] and [saves][n] */
  int64_t saved;
  double *saved_time, *saved_l2, *saved_linf, *saved_solution;
} solve;

/* What a callback of the march needs. */
typedef struct {
  task *t;
  solve *s;
} solve_context;

/* Assembles and solves what was read into s->in: phi is there. What it fails of is in t->error. */
sct_status solve_compute(task *t, solve *s);

/* Brings fields, conditions, system and Dirichlet values to a time: `advance` of a march, `of` a
 * solve_context. */
sct_status solve_advance(void *of, double time, sct_system **system, double *phi, sct_error *err);

void solve_clear(void *state);

#endif
