/* render_vtp.c - a table as VTK PolyData (.vtp): a vertex per point, fields as point data, all
 * arrays appended raw behind the XML (VTK File Formats, "XML File Formats"). Vectors have three
 * components, as VTK wants them. */
#include <string.h>

#include "point_table.h"
#include "render_back.h"

/* An array of the file: n rows of `columns` numbers, each written `width` wide (zeros behind). */
typedef struct {
  const char *name;
  int columns, width;
  const double *data; /* NULL: integers, start + row */
  int32_t start;
} array;

static size_t bytes_of(const array *a, int64_t rows) {
  return (size_t)rows * (a->data ? (size_t)a->width * sizeof(double) : sizeof(int32_t));
}

static bool put_doubles(task *t, const array *a, int64_t rows, rendered *out) {
  if (a->columns == a->width) {
    return put(t, out, a->data, (size_t)rows * (size_t)a->width * sizeof(double));
  }
  for (int64_t row = 0; row < rows; row++) {
    double wide[3] = {0};
    for (int c = 0; c < a->columns; c++) wide[c] = a->data[row * a->columns + c];
    if (!put(t, out, wide, sizeof wide)) return false;
  }
  return true;
}

static bool put_integers(task *t, const array *a, int64_t rows, rendered *out) {
  for (int64_t row = 0; row < rows; row++) {
    const int32_t value = a->start + (int32_t)row;
    if (!put(t, out, &value, sizeof value)) return false;
  }
  return true;
}

static bool put_array(task *t, const array *a, int64_t rows, rendered *out) {
  const uint64_t size = bytes_of(a, rows);
  if (!put(t, out, &size, sizeof size)) return false;
  return a->data ? put_doubles(t, a, rows, out) : put_integers(t, a, rows, out);
}

/* The element that announces an array; *offset moves past it. */
static bool put_element(task *t, const array *a, const table_field *f, int dim, int64_t rows,
                        size_t *offset, rendered *out) {
  bool done = put_text(t, out, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\"",
                       a->data ? "Float64" : "Int32", a->name, a->width);
  for (int c = 0; done && f && c < a->width && f->columns > 1; c++) {
    const char *name = component_name(f, dim, c);
    if (*name) done = put_text(t, out, " ComponentName%d=\"%s\"", c, name);
  }
  if (done) done = put_text(t, out, " format=\"appended\" offset=\"%zu\"/>\n", *offset);
  *offset += sizeof(uint64_t) + bytes_of(a, rows);
  return done;
}

static array field_array(const table_field *f, int dim) {
  return (array){.name = f->name,
                 .columns = f->columns,
                 .width = table_field_is_vector(f, dim) ? 3 : f->columns,
                 .data = f->data};
}

enum { POINTS, CONNECTIVITY, OFFSETS, FIXED };

static void fixed_arrays(const point_table *table, array fixed[FIXED]) {
  fixed[POINTS] = (array){.name = "Points", .columns = table->dim, .width = 3, .data = table->x};
  fixed[CONNECTIVITY] = (array){.name = "connectivity", .columns = 1, .width = 1};
  fixed[OFFSETS] = (array){.name = "offsets", .columns = 1, .width = 1, .start = 1};
}

static bool put_xml(task *t, const point_table *table, const array fixed[FIXED], rendered *out) {
  const int64_t n = table->rows;
  size_t offset = 0;
  bool done = put_text(
      t, out,
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<Piece "
      "NumberOfPoints=\"%lld\" NumberOfVerts=\"%lld\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"0\">\n<Points>\n",
      (long long)n, (long long)n);
  done = done && put_element(t, &fixed[POINTS], NULL, 0, n, &offset, out) &&
         put_text(t, out, "</Points>\n<Verts>\n") &&
         put_element(t, &fixed[CONNECTIVITY], NULL, 0, n, &offset, out) &&
         put_element(t, &fixed[OFFSETS], NULL, 0, n, &offset, out) &&
         put_text(t, out, "</Verts>\n<PointData>\n");
  for (int k = 0; done && k < table->count; k++) {
    const table_field *f = &table->field[k];
    const array a = field_array(f, table->dim);
    done = put_element(t, &a, f, table->dim, n, &offset, out);
  }
  return done && put_text(t, out,
                          "</PointData>\n</Piece>\n</PolyData>\n<AppendedData "
                          "encoding=\"raw\">\n_");
}

bool render_vtp(task *t, const result *r, const result_output *one, rendered *out) {
  point_table table;
  array fixed[FIXED];
  if (!point_table_of(t, r, one, &table)) return false;
  if (!table.dim) return sct_fail(&t->error, SCT_E_ARGUMENT, -1, "there are no points"), false;
  fixed_arrays(&table, fixed);
  bool done = put_xml(t, &table, fixed, out);
  for (int k = 0; done && k < FIXED; k++) done = put_array(t, &fixed[k], table.rows, out);
  for (int k = 0; done && k < table.count; k++) {
    const array a = field_array(&table.field[k], table.dim);
    done = put_array(t, &a, table.rows, out);
  }
  return done && put_text(t, out, "\n</AppendedData>\n</VTKFile>\n");
}
