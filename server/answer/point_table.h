/* point_table.h - a result as a table: a row per point, columns of coordinates and fields. What CSV
 * and VTP are made of.
 * Proof: unit.render
 */
#ifndef SCATTERD_POINT_TABLE_H
#define SCATTERD_POINT_TABLE_H

#include "result.h"

typedef struct {
  const char *name;
  output_role role;
  int columns;
  const double *data; /* [rows][columns] */
} table_field;

typedef struct {
  int64_t rows;
  int dim;         /* 0: there are no coordinates */
  const double *x; /* [rows][dim] */
  int count;
  table_field field[PROCESS_OUTPUTS_MAX];
} point_table;

enum { COLUMN_NAME = 96 };

/* The table of one output (coordinates beside it where there are any), or of all outputs with a
 * value per point (one NULL). Borrows from the result. False with t->error set where the shapes do
 * not agree. */
bool point_table_of(task *t, const result *r, const result_output *one, point_table *table);

/* Name of column c of a field: "solution", "gradient_x", "effective_diffusivity_xy"; `dim` tells
 * how a tensor is laid out. Coordinates: "x", "y", "z". */
const char *column_name(const table_field *f, int dim, int c, char room[COLUMN_NAME]);
extern const char *const axis_names[];

/* Is it a vector in the space of the points? */
bool table_field_is_vector(const table_field *f, int dim);

/* "x" or "xy": what column c is of a vector or tensor; "" of anything else. */
const char *component_name(const table_field *f, int dim, int c);

#endif
