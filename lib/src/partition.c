/* A point of another part is in the halo if a search over own points finds one around it: so the
 * structure is built over n / P points, and asked only by those inside a box. */
#include "scatter/partition.h"

#include <math.h>
#include <string.h>

#include "alloc.h"
#include "scatter/search.h"

/* ---- the partition ---- */

static sct_status invert(sct_partition *p, sct_error *err) {
  sct_status status = sct_alloc(&p->place, p->n, sizeof *p->place, err);
  for (int64_t k = 0; status == SCT_OK && k < p->n; k++) p->place[p->order[k]] = (int32_t)k;
  return status;
}

sct_status sct_partition_build(const sct_cloud *cloud, int parts, bool along_curve,
                               sct_partition **out, sct_error *err) {
  sct_partition *p = NULL;
  *out = NULL;
  if (parts < 1) return sct_fail(err, SCT_E_ARGUMENT, -1, "got %d parts, needs 1 or more", parts);
  sct_status status = sct_alloc_zero(&p, 1, sizeof *p, err);
  if (status != SCT_OK) return status;
  p->n = cloud->n;
  p->parts = parts;
  if (!along_curve) {
    status = sct_alloc(&p->order, p->n, sizeof *p->order, err);
    if (status == SCT_OK) status = sct_cloud_order(cloud, p->order, err);
    if (status == SCT_OK) status = invert(p, err);
  }
  if (status != SCT_OK) sct_partition_free(&p);
  *out = p;
  return status;
}

void sct_partition_free(sct_partition **partition) {
  if (*partition == NULL) return;
  sct_release(&(*partition)->order);
  sct_release(&(*partition)->place);
  sct_release(partition);
}

int64_t sct_partition_start(const sct_partition *p, int k) {
  return p->n / p->parts * k + p->n % p->parts * k / p->parts;
}

int32_t sct_partition_point(const sct_partition *p, int64_t place) {
  return p->order != NULL ? p->order[place] : (int32_t)place;
}

/* ---- the halo ---- */

typedef enum { ELSEWHERE, HALO, OWN } belonging;

typedef struct {
  const sct_cloud *whole;
  uint8_t *belongs; /* [n] belonging */
} marking;

/* The coordinates of some points, side by side. SCT_E_MEMORY. */
static sct_status gather(const sct_cloud *whole, int64_t n, const int32_t *point, double **x,
                         sct_error *err) {
  const int dim = whole->dim;
  sct_status status = sct_alloc(x, n * dim, sizeof **x, err);
  if (status != SCT_OK) return status;
  for (int64_t m = 0; m < n; m++) {
    memcpy(*x + m * dim, whole->x + (int64_t)point[m] * dim, (size_t)dim * sizeof **x);
  }
  return SCT_OK;
}

typedef struct {
  double lower[SCT_DIM_MAX], upper[SCT_DIM_MAX];
} box;

/* Around all points, with a margin. */
static box box_around(const sct_cloud *cloud, double margin) {
  box b = {{0}, {0}};
  for (int a = 0; a < cloud->dim; a++) {
    b.lower[a] = INFINITY;
    b.upper[a] = -INFINITY;
    for (int64_t m = 0; m < cloud->n; m++) {
      const double x = cloud->x[m * cloud->dim + a];
      b.lower[a] = x < b.lower[a] ? x : b.lower[a];
      b.upper[a] = x > b.upper[a] ? x : b.upper[a];
    }
    b.lower[a] -= margin;
    b.upper[a] += margin;
  }
  return b;
}

static bool is_inside(const box *b, int dim, const double *x) {
  for (int a = 0; a < dim; a++) {
    if (x[a] < b->lower[a] || x[a] > b->upper[a]) return false;
  }
  return true;
}

/* Marks what is less than `width` away from one of these points. The box is a little wider, for
 * its margin is rounded. */
static sct_status mark_around(const marking *m, int64_t n, const int32_t *point, double width,
                              const sct_work *work, sct_error *err) {
  const int dim = m->whole->dim;
  double *x = NULL;
  sct_search *search = NULL;
  if (n == 0) return SCT_OK;
  sct_status status = gather(m->whole, n, point, &x, err);
  const sct_cloud cloud = {dim, n, x};
  if (status == SCT_OK) {
    status = sct_search_build(&cloud, width, SCT_SEARCH_AUTO, work, &search, err);
  }
  if (status == SCT_OK) {
    const box near = box_around(&cloud, width * (1 + 1e-6));
    for (int64_t j = 0; j < m->whole->n; j++) {
      const double *xj = m->whole->x + j * dim;
      if (m->belongs[j] != ELSEWHERE || !is_inside(&near, dim, xj)) continue;
      if (sct_search_around(search, xj, width, 0, NULL) > 0) m->belongs[j] = HALO;
    }
  }
  sct_search_free(&search);
  sct_release(&x);
  return status;
}

/* The points of `point` [n] with the least reach above `width`, which is returned: infinity if
 * there are none. */
static double next_reach(int64_t n, const int32_t *point, double width, const double *reach,
                         int32_t *found, int64_t *count) {
  double least = INFINITY;
  *count = 0;
  for (int64_t m = 0; reach != NULL && m < n; m++) {
    const double own = reach[point[m]];
    if (!(own > width) || own > least) continue;
    if (own < least) *count = 0;
    least = own;
    found[(*count)++] = point[m];
  }
  return least;
}

/* Supports are of few widths (stencil.h): one search for each. */
static sct_status mark(const marking *m, const sct_partition *p, int k, double width,
                       const double *reach, const sct_work *work, sct_error *err) {
  const int64_t first = sct_partition_start(p, k), own = sct_partition_start(p, k + 1) - first;
  int32_t *list = NULL, *far = NULL;
  int64_t count;
  sct_status status = sct_alloc(&list, own, sizeof *list, err);
  if (status == SCT_OK) status = sct_alloc(&far, own, sizeof *far, err);
  if (status != SCT_OK) goto done;
  for (int64_t r = 0; r < own; r++) list[r] = sct_partition_point(p, first + r);
  for (int64_t r = 0; r < own; r++) m->belongs[list[r]] = OWN;
  status = mark_around(m, own, list, width, work, err);
  for (double w = width; status == SCT_OK && w < INFINITY;) {
    w = next_reach(own, list, w, reach, far, &count);
    status = mark_around(m, count, far, w, work, err);
  }
done:
  sct_release(&list);
  sct_release(&far);
  return status;
}

/* ---- the part ---- */

/* All that belongs to it, in the order of the whole cloud. */
static sct_status collect(const marking *m, sct_part *part, sct_error *err) {
  for (int64_t j = 0; j < m->whole->n; j++) part->n += m->belongs[j] != ELSEWHERE;
  sct_status status = sct_alloc(&part->point, part->n, sizeof *part->point, err);
  if (status == SCT_OK) status = sct_alloc(&part->is_own, part->n, sizeof *part->is_own, err);
  if (status != SCT_OK) return status;
  int64_t count = 0;
  for (int64_t j = 0; j < m->whole->n; j++) {
    if (m->belongs[j] == ELSEWHERE) continue;
    part->is_own[count] = m->belongs[j] == OWN;
    part->own += part->is_own[count];
    part->point[count++] = (int32_t)j;
  }
  status = gather(m->whole, part->n, part->point, &part->x, err);
  part->cloud = (sct_cloud){m->whole->dim, part->n, part->x};
  return status;
}

sct_status sct_part_build(const sct_cloud *cloud, const sct_partition *partition, int k,
                          double width, const double *reach, const sct_work *work, sct_part **out,
                          sct_error *err) {
  marking m = {.whole = cloud};
  sct_part *part = NULL;
  *out = NULL;
  sct_status status = sct_alloc_zero(&part, 1, sizeof *part, err);
  if (status == SCT_OK) status = sct_alloc_zero(&m.belongs, cloud->n, sizeof *m.belongs, err);
  if (status == SCT_OK) status = mark(&m, partition, k, width, reach, work, err);
  if (status == SCT_OK) status = collect(&m, part, err);
  sct_release(&m.belongs);
  if (status != SCT_OK) sct_part_free(&part);
  *out = part;
  return status;
}

void sct_part_free(sct_part **part) {
  if (*part == NULL) return;
  sct_release(&(*part)->point);
  sct_release(&(*part)->is_own);
  sct_release(&(*part)->x);
  sct_release(part);
}
