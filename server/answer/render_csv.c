/* render_csv.c - a table as text/csv (RFC 4180): a line of names, a line per row; numbers read back
 * bit for bit. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "number_text.h"
#include "point_table.h"
#include "render_back.h"

static bool put_names(task *t, const point_table *table, rendered *out) {
  char name[COLUMN_NAME];
  const char *comma = "";
  for (int a = 0; a < table->dim; a++, comma = ",") {
    if (!put_text(t, out, "%s%s", comma, axis_names[a])) return false;
  }
  for (int k = 0; k < table->count; k++) {
    const table_field *f = &table->field[k];
    for (int c = 0; c < f->columns; c++, comma = ",") {
      if (!put_text(t, out, "%s%s", comma, column_name(f, table->dim, c, name))) return false;
    }
  }
  return put_text(t, out, "\r\n");
}

static char *print(char *to, double value) {
  if (isfinite(value)) return number_print(to, value);
  return to + sprintf(to, isnan(value) ? "nan" : value > 0 ? "inf" : "-inf");
}

static char *print_columns(char *to, const double *row, int columns) {
  for (int c = 0; c < columns; c++) {
    to = print(to, row[c]);
    *to++ = ',';
  }
  return to;
}

static char *print_row(char *to, const point_table *table, int64_t row) {
  if (table->dim) to = print_columns(to, table->x + row * table->dim, table->dim);
  for (int k = 0; k < table->count; k++) {
    const table_field *f = &table->field[k];
    to = print_columns(to, f->data + row * f->columns, f->columns);
  }
  to[-1] = '\r'; /* in place of the last comma */
  *to++ = '\n';
  return to;
}

static size_t row_room(const point_table *table) {
  size_t columns = (size_t)table->dim;
  for (int k = 0; k < table->count; k++) columns += (size_t)table->field[k].columns;
  return columns * (NUMBER_TEXT_MAX + 1) + 2;
}

bool render_csv(task *t, const result *r, const result_output *one, rendered *out) {
  point_table table;
  if (!point_table_of(t, r, one, &table) || !put_names(t, &table, out)) return false;
  const size_t most = row_room(&table);
  for (int64_t row = 0; row < table.rows && most > 2; row++) {
    char *to = grow_room(&out->bytes, most);
    if (!to) return render_no_memory(t);
    out->bytes.size += (size_t)(print_row(to, &table, row) - to);
  }
  snprintf(out->type, sizeof out->type, "text/csv; charset=utf-8; header=present");
  return true;
}
