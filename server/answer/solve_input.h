/* solve_input.h - the inputs of process `solve`: an equation on a cloud, steady or in time. */
#ifndef SCATTERD_SOLVE_INPUT_H
#define SCATTERD_SOLVE_INPUT_H

#include "boundary_input.h"
#include "cloud_input.h"
#include "field_input.h"
#include "scatter/march.h"
#include "scatter/stencil.h"

typedef struct {
  cloud_input cloud;
  sct_operator op;
  field velocity, diffusivity, source, reaction; /* at the start; see solve_input_advance */
  field initial;                                 /* of a time-dependent problem */
  field exact;                                   /* at the end; value NULL: not given */
  boundary_input boundary;
  bool is_transient;
  sct_march_options march;            /* march.solve: how to solve, steady too */
  char step_pointer[PROBLEM_POINTER]; /* to what sets the time step */
} solve_input;

extern const char *const solve_inputs[]; /* names, NULL at the end */

/* Reads all inputs into the zeroed *s; what is wrong becomes complaints. */
void solve_input_read(task *t, const item *in, solve_input *s);

/* Fields and boundary as the library wants them; they borrow from *s. */
sct_fields solve_input_fields(const solve_input *s);
sct_boundary solve_input_boundary(const solve_input *s);

/* Which parts depend on time: SCT_VARIES_*. */
int solve_input_varies(const solve_input *s);

/* Brings fields and boundary to another time. False with a complaint. */
bool solve_input_advance(task *t, solve_input *s, double time);

#endif
