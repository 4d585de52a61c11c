/* cloud_input.h - the input `cloud`: points that were posted, or a lattice.
 *
 * Points are renumbered along a space-filling curve before anything is computed with them. Inside,
 * a point has its place k; to the client it is point order[k]. Groups speak the client's numbers.
 * Proof: unit.answer (renumbering is invisible)
 */
#ifndef SCATTERD_CLOUD_INPUT_H
#define SCATTERD_CLOUD_INPUT_H

#include "read.h"
#include "scatter/cloud.h"

/* Points with a name, and their outward normals if they have any. */
typedef struct {
  const char *name;
  int64_t n;
  const int32_t *index; /* [n] client's numbers, in the client's order */
  numbers normals;      /* [0, 1 or n][dim]: none, one for all, one per point */
} point_group;

typedef struct cloud_input {
  char pointer[PROBLEM_POINTER]; /* to the posted points in the request; of a lattice, to it */
  sct_cloud cloud;               /* by place */
  const double *posted;          /* [n][dim] by the client's numbers */
  int32_t *order;                /* [n] client's number of a place */
  int32_t *place;                /* [n] place of a client's number */
  double spacing; /* h (length); 0: not said, take the median distance of neighbours */
  bool is_lattice;
  sct_lattice lattice;
  point_group side[SCT_SIDE_COUNT]; /* of a lattice, made when first asked for (name NULL before) */
  int64_t groups;                   /* of posted points */
  point_group *group;               /* [groups] */
} cloud_input;

/* Reads the input. False, with complaints or t->error, if there is no cloud to go on with. */
bool cloud_input_read(task *t, const item *it, cloud_input *c);

/* The group called `name`. False with a complaint at `at` if there is none. */
bool cloud_input_group(task *t, const item *at, cloud_input *c, const char *name,
                       point_group *group);

/* Which points count in norms when no boundary says it: the group `interior` of a lattice, points
 * in no group else, all if that leaves none. mask [n] by place; NULL when out of memory. */
uint8_t *cloud_input_interior(task *t, cloud_input *c);

/* Reads an outward normal or one per point: [dim] or [n][dim]. Absent: *normals untouched. */
bool read_normals(task *t, const item *it, int64_t n, int dim, numbers *normals);

/* Back to the client's numbers: out[order[k]] = value[k], rows of `components`. NULL when out of
 * memory. */
double *cloud_input_restore(task *t, const cloud_input *c, const double *value, int components);

/* Turns the point numbers of an error from the library into the client's. */
void cloud_input_translate(const cloud_input *c, sct_error *error);

#endif
