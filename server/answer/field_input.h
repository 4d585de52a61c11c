/* field_input.h - fields on points: a number, an array, or an expression.
 *
 * A field is evaluated as it is read, so that a value that is not finite is found with everything
 * else that is wrong; afterwards it is an array in the order of its points.
 * Proof: unit.answer
 */
#ifndef SCATTERD_FIELD_INPUT_H
#define SCATTERD_FIELD_INPUT_H

#include "cloud_input.h"
#include "expression.h"

/* The points a field is given on: some of a cloud, or all. */
typedef struct {
  const cloud_input *cloud;
  int64_t n;
  const int32_t *client; /* [n] client's numbers */
  const int32_t *place;  /* [n] places; NULL: all points, k itself */
} sites;

sites sites_all(const cloud_input *c);

typedef struct {
  double *value;  /* [n][components]; NULL: absent, or nothing could be read */
  int components; /* 1, or dim */
  bool varies;    /* with t: field_advance brings it to another time */
  sites on;
  expression component[SCT_DIM_MAX]; /* text NULL: not an expression */
  const char *pointer[SCT_DIM_MAX];  /* where a component stands in the request */
} field;

/* number | array of n numbers (or, on some points, one per point of the cloud) | expression,
 * evaluated at `time`. `on` NULL: there is no cloud; the value is checked as far as possible.
 * False with complaints. An absent item leaves *f all zero. */
bool read_scalar_field(task *t, const item *it, const sites *on, double time, field *f);

/* array of dim numbers or expressions | n x dim array. */
bool read_vector_field(task *t, const item *it, const sites *on, double time, field *f);

/* Evaluates the components that depend on time anew. SCT_E_NOT_FINITE with a complaint. */
bool field_advance(task *t, field *f, double time);

#endif
