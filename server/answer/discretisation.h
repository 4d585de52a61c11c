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

/* The distance [n] of every point to its nearest, and the spacing h: the one posted, or their
 * median. Failures stand in t->error: SCT_E_DEFICIENT for a point without another, SCT_E_ARGUMENT
 * for distances whose squares are too small or too large for a double. */
sct_status discretisation_spacing(task *t, const cloud_input *c, const sct_search *search,
                                  double *nearest, double *spacing);

/* Finds neighbours and prepares the rows of `op`; books the laps search and stencil. Failures
 * stand in t->error. */
sct_status discretisation_build(task *t, const cloud_input *c, const sct_operator *op,
                                discretisation *d);
void discretisation_clear(discretisation *d);

#endif
