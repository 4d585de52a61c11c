#include "point_table.h"

#include <stdio.h>
#include <string.h>

#include "scatter/cloud.h"

const char *const axis_names[] = {"x", "y", "z"};

/* A row per point, [n] or [n][k]; rank 1 of a coordinates array is none. */
static bool shape_of(const doc *d, int64_t *rows, int *columns) {
  if (d->kind != DOC_NUMBERS || d->rank > 2) return false;
  *rows = d->shape[0];
  *columns = d->rank == 2 ? (int)d->shape[1] : 1;
  return d->rank == 1 || d->shape[1] <= 65536;
}

static bool add_coordinates(const doc *d, point_table *table) {
  return !d || (shape_of(d, &table->rows, &table->dim) && (table->x = d->data, true) &&
                table->dim >= 1 && table->dim <= SCT_DIM_MAX);
}

static bool add_field(const result_output *o, point_table *table) {
  table_field *f = &table->field[table->count];
  int64_t rows;
  if (o->role == OUTPUT_COORDINATES) return true;
  *f = (table_field){.name = o->name, .role = o->role, .data = o->value->data};
  if (!shape_of(o->value, &rows, &f->columns)) return false;
  if (table->dim == 0 && table->count == 0) table->rows = rows;
  table->count++;
  return rows == table->rows;
}

static bool has_place(const result_output *o) {
  return o->role != OUTPUT_OTHER && o->role != OUTPUT_ARRAY;
}

static bool fill(const result *r, const result_output *one, point_table *table) {
  if (!one || has_place(one)) {
    if (!add_coordinates(r->coordinates, table)) return false;
  }
  if (one) return add_field(one, table);
  for (int k = 0; k < r->count; k++) {
    if (has_place(&r->output[k]) && !add_field(&r->output[k], table)) return false;
  }
  return true;
}

bool point_table_of(task *t, const result *r, const result_output *one, point_table *table) {
  *table = (point_table){0};
  if (fill(r, one, table)) return true;
  (void)sct_fail(&t->error, SCT_E_ARGUMENT, -1, "the outputs have not one row per point each");
  return false;
}

bool table_field_is_vector(const table_field *f, int dim) {
  return f->role == OUTPUT_FIELD && f->columns > 1 && f->columns == dim;
}

const char *component_name(const table_field *f, int dim, int c) {
  static const char *const tensors[][6] = {
      {"xx"}, {"xx", "yy", "xy"}, {"xx", "yy", "zz", "xy", "xz", "yz"}};
  if (table_field_is_vector(f, dim)) return axis_names[c];
  bool is_tensor = f->role == OUTPUT_TENSOR && dim >= 1 && f->columns == dim * (dim + 1) / 2;
  return is_tensor ? tensors[dim - 1][c] : "";
}

const char *column_name(const table_field *f, int dim, int c, char room[COLUMN_NAME]) {
  const char *component = component_name(f, dim, c);
  if (*component) {
    snprintf(room, COLUMN_NAME, "%s_%s", f->name, component);
  } else if (f->columns > 1) {
    snprintf(room, COLUMN_NAME, "%s_%d", f->name, c);
  } else {
    snprintf(room, COLUMN_NAME, "%s", f->name);
  }
  return room;
}
