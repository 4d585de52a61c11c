/* boundary_input.h - the input `boundary`: conditions on points, the later entry winning.
 * Proof: unit.answer
 */
#ifndef SCATTERD_BOUNDARY_INPUT_H
#define SCATTERD_BOUNDARY_INPUT_H

#include "field_input.h"
#include "scatter/assemble.h"

/* One entry, on points in the order of the client's list. */
typedef struct {
  sct_condition type;
  sites on;
  field value;
  field coefficient; /* robin */
  numbers normals;   /* neumann, robin: [1 or n][dim] */
} boundary_entry;

typedef struct {
  int64_t entries;
  boundary_entry *entry;
  int64_t constrained; /* points with a Dirichlet value */
  bool varies;         /* value with t */
  bool matrix_varies;  /* coefficient with t */
  /* What the library wants, by place */
  uint8_t *condition;  /* [n] */
  double *value;       /* [n] */
  double *coefficient; /* [n] */
  double *normal;      /* [n][dim] */
  int32_t *owner;      /* [n] entry that has the point, -1: none */
} boundary_input;

/* Reads the input with its fields at `time`. `c` NULL: there is no cloud; what can be checked
 * without is. An absent input leaves all points interior. False with complaints. */
bool boundary_input_read(task *t, const item *it, cloud_input *c, double time, boundary_input *b);

/* `on`: the name of a group of the cloud, or a list of points. False with a complaint. */
bool read_points(task *t, const item *it, cloud_input *c, point_group *group);

/* Brings values and coefficients to another time. False with a complaint. */
bool boundary_input_advance(task *t, boundary_input *b, double time);

#endif
