/* flow_domain_input.h - the input `domain` of process `flow`: boxes of fluid, solid blocks, sides,
 * and the mesh over them. Proof: http.flow */
#ifndef SCATTERD_FLOW_DOMAIN_INPUT_H
#define SCATTERD_FLOW_DOMAIN_INPUT_H

#include "expression.h"
#include "read.h"
#include "scatter/flow.h"

/* Numbers or expressions of x and y, for whoever asks for them at places. */
typedef struct {
  task *t;
  int components;
  double number[2];
  expression text[2]; /* .text NULL: the number */
} flow_field;

/* number | expression, as a field of one component; an absent item leaves 0. */
bool flow_field_read_scalar(task *t, const item *it, flow_field *f);

/* [2] of these. */
bool flow_field_read_vector(task *t, const item *it, flow_field *f);

/* The sct_flow_field of a flow_field (its context). */
sct_status flow_field_values(void *field, int64_t n, const double *x, double *value,
                             sct_error *err);

typedef struct {
  sct_flow_domain domain; /* what follows is its memory, in the arena */
  double *edge[2];
  sct_flow_box *fluid, *solid;
  sct_flow_side *side;
  flow_field *profile; /* [sides] */
  double spacing;
} flow_domain_input;

/* Reads the domain and lays its mesh: lines through all bounds and ends, and between them cells
 * about `spacing` wide, at least two, clustered as said; or the lines given. */
bool flow_domain_input_read(task *t, const item *it, double clustering, flow_domain_input *d);

#endif
