/* discretisation.h - neighbours and operators on a cloud: what all processes begin with. */
#ifndef SCATTERD_DISCRETISATION_H
#define SCATTERD_DISCRETISATION_H

#include "cloud_input.h"
#include "scatter/search.h"
#include "scatter/stencil.h"

typedef struct {
  sct_search *search;
  sct_stencil *stencil;
  double *nearest; /* [n] distance to the nearest point (length) */
  double spacing;  /* h (length) */
} discretisation;

/* Finds neighbours and prepares the rows of `op`; books the laps search and stencil. Failures
 * stand in t->error. */
sct_status discretisation_build(task *t, const cloud_input *c, const sct_operator *op,
                                discretisation *d);
void discretisation_clear(discretisation *d);

#endif
