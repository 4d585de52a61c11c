/* parameter_slope.h - how the data of a solve change with one of its parameters.
 */
#ifndef SCATTERD_PARAMETER_SLOPE_H
#define SCATTERD_PARAMETER_SLOPE_H

#include "scatter/slope.h"
#include "solve_input.h"

typedef struct {
  const char *name;
  double value;
  sct_data data;   /* by place, as fields and conditions are; NULL: does not name the parameter */
  double *initial; /* [n] likewise */
  bool taken;      /* once at least */
  bool varies;     /* data with t */
} parameter_slope;

/* Takes the slope at `time`. Called again for another time it does again what varies. False with
 * t->error. Memory is the task's. */
bool parameter_slope_take(task *t, const solve_input *s, double time, parameter_slope *p);

/* Do rows of the matrix change with it, and do they by velocity or diffusivity? */
bool parameter_slope_moves(const parameter_slope *p);
bool parameter_slope_weighs(const parameter_slope *p);

/* gradient . change over all data; sum += factor * change. */
double parameter_slope_dot(const parameter_slope *p, const sct_data *gradient, int64_t n, int dim);
void parameter_slope_add(const parameter_slope *p, double factor, int64_t n, int dim,
                         sct_data *sum);

/* Zeroes [n] for each of the data that one of `count` parameters changes; NULL for the others.
 * False without memory. */
bool parameter_slope_zeros(task *t, const parameter_slope *p, int64_t count, int64_t n, int dim,
                           sct_data *zeros);

enum { DATA_MEMBERS = 6 };
double **data_member(sct_data *d, int k); /* velocity, the only one of dim components, is 0 */

#endif
