#include "scatter/stencil.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "alloc.h"
#include "ascend.h"
#include "points.h"
#include "stencil_inside.h"

/* A distance this close to the support counts as outside: on a lattice, whether a point at 2 h
 * is nearer than 2 h is a matter of rounding. */
static const double TIE = 1e-10;

/* Supports (in spacings) a deficient point is widened to. The far end is for clouds without any
 * order, whose gaps are many times their median distance. */
static const double WIDER[] = {2.0, 2.5, 3.1, 3.6, 4.1, 5.1, 6.5, 8.2, 11, 16, 23, 32};
enum { WIDER_COUNT = sizeof WIDER / sizeof WIDER[0] };

/* If no support gives weights as stable as the scheme asks, the least unstable of them are taken up
 * to this excess. */
static const double LOOSE = 15;

/* ---- names ---- */

#define SCT_NAME_TEXT(symbol, name) name,
static const char *const schemes[] = {SCT_SCHEME_LIST(SCT_NAME_TEXT)};
static const char *const upwinds[] = {SCT_UPWIND_LIST(SCT_NAME_TEXT)};
static const char *const densities[] = {SCT_DENSITY_LIST(SCT_NAME_TEXT)};
static const char *const weights[] = {SCT_WEIGHT_LIST(SCT_NAME_TEXT)};
#undef SCT_NAME_TEXT

static int find(const char *const *names, int count, const char *name) {
  int k = 0;
  while (k < count && (name == NULL || strcmp(names[k], name) != 0)) k++;
  return k;
}

#define NAMED(type, names, count)                                     \
  const char *type##_name(type value) {                               \
    return (unsigned)value < (unsigned)(count) ? names[value] : NULL; \
  }                                                                   \
  type type##_find(const char *name) {                                \
    return (type)find(names, count, name);                            \
  }
NAMED(sct_scheme, schemes, SCT_SCHEME_COUNT)
NAMED(sct_upwind, upwinds, SCT_UPWIND_COUNT)
NAMED(sct_density, densities, SCT_DENSITY_COUNT)
NAMED(sct_weight, weights, SCT_WEIGHT_COUNT)
#undef NAMED

/* ---- operators ---- */

sct_operator sct_operator_default(sct_scheme scheme, int degree) {
  static const double lsmps_radius[] = {[2] = 2.1, [3] = 2.5, [4] = 3.1};
  sct_operator op = {.scheme = scheme,
                     .degree = degree >= 2 && degree <= 4 ? degree : 2,
                     .weight = SCT_WEIGHT_KERNEL_R2,
                     .kernel = sct_kernel_find(scheme == SCT_MPS ? "center" : "rational"),
                     .radius = 2.0,
                     .density = scheme == SCT_MPS ? SCT_DENSITY_REFERENCE : SCT_DENSITY_LOCAL,
                     .upwind = SCT_UPWIND_NONE,
                     .gamma_scale = 1,
                     .reference_length = 1,
                     .reference_speed = 1};
  if (scheme == SCT_LSMPS) op.radius = lsmps_radius[op.degree];
  return op;
}

static sct_status check_upwind(const sct_operator *op, sct_error *err) {
  if (op->upwind == SCT_UPWIND_EXACT && !(op->kernel->slope(1 / op->radius) < 0)) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "upwind exact needs a kernel that falls at one spacing, %s is flat at 1/%g",
                    op->kernel->name, op->radius);
  }
  if (op->upwind == SCT_UPWIND_LIMITED && op->scheme == SCT_LSMPS && op->degree > 2) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "upwind limited is of second order and needs lsmps of degree 2, got %d",
                    op->degree);
  }
  if (op->upwind != SCT_UPWIND_PUBLISHED) return SCT_OK;
  if (op->scheme != SCT_MPS || strcmp(op->kernel->name, "center") != 0 || op->radius != 2) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "upwind published needs scheme mps, kernel center and radius 2, got %s, %s, %g",
                    schemes[op->scheme], op->kernel->name, op->radius);
  }
  return SCT_OK;
}

sct_status sct_operator_check(const sct_operator *op, sct_error *err) {
  if ((unsigned)op->scheme >= SCT_SCHEME_COUNT || (unsigned)op->upwind >= SCT_UPWIND_COUNT ||
      (unsigned)op->density >= SCT_DENSITY_COUNT || (unsigned)op->weight >= SCT_WEIGHT_COUNT ||
      op->kernel == NULL) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "operator has no such scheme, kernel or option");
  }
  if (!(op->radius >= 1 && op->radius <= 8)) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "radius is %g spacings, needs 1 to 8", op->radius);
  }
  if (op->degree < 2 || op->degree > 4) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "degree is %d, needs 2 to 4", op->degree);
  }
  if (!(op->gamma_scale > 0 && op->reference_length > 0 && op->reference_speed > 0 &&
        isfinite(op->gamma_scale + op->reference_length + op->reference_speed))) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "gamma scale, reference length and speed are %g, %g, %g, need to be positive",
                    op->gamma_scale, op->reference_length, op->reference_speed);
  }
  return check_upwind(op, err);
}

/* ---- preparation ---- */

/* S_w and lambda S_w over the offsets (a, b, c) h of a lattice. */
static void reference_sums(sct_stencil *s) {
  const int reach = (int)s->op.radius, dim = s->cloud.dim;
  const int reach_y = dim > 1 ? reach : 0, reach_z = dim > 2 ? reach : 0;
  for (int c = -reach_z; c <= reach_z; c++) {
    for (int b = -reach_y; b <= reach_y; b++) {
      for (int a = -reach; a <= reach; a++) {
        const double r = sqrt(a * a + b * b + c * c);
        if (r == 0 || r >= s->op.radius * (1 - TIE)) continue;
        const double w = s->op.kernel->w(r / s->op.radius);
        s->reference_w += w;
        s->reference_w_r2 += w * r * r * s->spacing * s->spacing;
      }
    }
  }
}

/* Sums run over neighbours in the order of their numbers, so that a row is the same to the last bit
 * whatever structure found them, in whichever part of the cloud (partition.h). */
static sct_status sort_list(void *context, int64_t i, sct_room *room, sct_error *err) {
  const sct_lists *lists = ((const sct_stencil *)context)->lists;
  (void)err;
  sct_ascend(lists->start[i + 1] - lists->start[i], lists->index + lists->start[i], room->index);
  return SCT_OK;
}

static int64_t longest_list(const sct_lists *lists) {
  int64_t longest = 0;
  for (int64_t i = 0; i < lists->n; i++) {
    const int64_t n = lists->start[i + 1] - lists->start[i];
    if (n > longest) longest = n;
  }
  return longest;
}

sct_status sct_stencil_build(const sct_cloud *cloud, const sct_search *search, double spacing,
                             const sct_operator *op, int64_t limit, const sct_work *work,
                             sct_stencil **out, sct_error *err) {
  sct_stencil *s = NULL;
  *out = NULL;
  sct_status status = sct_operator_check(op, err);
  if (status != SCT_OK) return status;
  if (!(spacing > 0 && isfinite(spacing))) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "spacing is %g, needs to be positive", spacing);
  }
  status = sct_alloc_zero(&s, 1, sizeof *s, err);
  if (status != SCT_OK) return status;
  s->cloud = *cloud;
  s->search = search;
  s->op = *op;
  s->spacing = spacing;
  s->limit = limit;
  reference_sums(s);
  status =
      sct_search_lists(search, op->radius * spacing * (1 - TIE), NULL, limit, work, &s->lists, err);
  if (status == SCT_OK) {
    s->longest = longest_list(s->lists);
    status = sct_points_run(s, 0, cloud->n, work, sort_list, s, err);
  }
  if (status != SCT_OK) sct_stencil_free(&s);
  *out = s;
  return status;
}

void sct_stencil_free(sct_stencil **stencil) {
  if (*stencil == NULL) return;
  sct_lists_free(&(*stencil)->lists);
  sct_release(stencil);
}

const sct_lists *sct_stencil_lists(const sct_stencil *stencil) {
  return stencil->lists;
}
const sct_cloud *sct_stencil_cloud(const sct_stencil *stencil) {
  return &stencil->cloud;
}
const sct_operator *sct_stencil_operator(const sct_stencil *stencil) {
  return &stencil->op;
}
double sct_stencil_spacing(const sct_stencil *stencil) {
  return stencil->spacing;
}
void sct_stencil_note_reach(sct_stencil *stencil, double *reach) {
  stencil->reach = reach;
}

/* ---- neighbourhoods ---- */

/* room: r, r2 of the n neighbours `index` of point i */
static void offsets(const sct_cloud *cloud, int64_t i, int64_t n, const int32_t *index,
                    sct_room *room) {
  const int dim = cloud->dim;
  const double *xi = cloud->x + i * dim;
  for (int64_t k = 0; k < n; k++) room->r2[k] = 0;
  for (int a = 0; a < dim; a++) {
    double *r = room->r[a];
    for (int64_t k = 0; k < n; k++) r[k] = cloud->x[(int64_t)index[k] * dim + a] - xi[a];
    for (int64_t k = 0; k < n; k++) room->r2[k] += r[k] * r[k];
  }
}

/* room: w = w(r / r_e), f = w / r^2 */
static void weigh(const sct_kernel *kernel, double support, int64_t n, sct_room *room) {
  const double inverse = 1 / support;
  for (int64_t k = 0; k < n; k++) room->scratch[k] = sqrt(room->r2[k]) * inverse;
  kernel->fill(n, room->scratch, room->w);
  for (int64_t k = 0; k < n; k++) room->f[k] = room->w[k] / room->r2[k];
}

int64_t sct_stencil_gather(const sct_stencil *stencil, int64_t i, sct_room *room, bool weighed,
                           const int32_t **index) {
  const sct_lists *lists = stencil->lists;
  const int64_t n = lists->start[i + 1] - lists->start[i];
  *index = lists->index + lists->start[i];
  offsets(&stencil->cloud, i, n, *index, room);
  if (weighed) weigh(stencil->op.kernel, stencil->op.radius * stencil->spacing, n, room);
  return n;
}

/* The neighbours of i within `support`, asked for anew, into room->index; n is -1 if there are more
 * than the limit. */
static sct_status wider_list(const sct_stencil *s, int64_t i, double support, sct_room *room,
                             int64_t *n, sct_error *err) {
  const double *xi = s->cloud.x + i * s->cloud.dim, within = support * (1 - TIE);
  const int64_t found = sct_search_around(s->search, xi, within, room->capacity, room->index);
  *n = -1;
  if (found > s->limit + 1) return SCT_OK;
  if (found > room->capacity) {
    const sct_status status = sct_room_reserve(room, found, err);
    if (status != SCT_OK) return status;
    sct_search_around(s->search, xi, within, found, room->index);
  }
  *n = 0;
  for (int64_t k = 0; k < found; k++) {
    if (room->index[k] != i) room->index[(*n)++] = room->index[k];
  }
  sct_ascend(*n, room->index, (void *)room->scratch); /* nothing else needs it yet */
  return SCT_OK;
}

/* Lays out the neighbours of i within `support` and fills the sums of the job; *crowded if there
 * are more than the limit, and nothing is laid out. */
static sct_status lay_out(const sct_stencil *s, int64_t i, double support, row_job *job,
                          const int32_t **index, bool *crowded, sct_error *err) {
  sct_room *room = job->room;
  const bool own = support == s->op.radius * s->spacing;
  if (own) {
    job->n = sct_stencil_gather(s, i, room, true, index);
  } else {
    int64_t n;
    const sct_status status = wider_list(s, i, support, room, &n, err);
    *crowded = n < 0;
    if (status != SCT_OK || *crowded) return status;
    job->n = n;
    *index = room->index;
    offsets(&s->cloud, i, n, room->index, room);
    weigh(s->op.kernel, support, n, room);
  }
  const bool reference = s->op.density == SCT_DENSITY_REFERENCE && own;
  job->support = support;
  job->sum_w = reference ? s->reference_w : row_sum(job->n, room->w);
  job->sum_w_r2 = reference ? s->reference_w_r2 : row_sum2(job->n, room->w, room->r2);
  return SCT_OK;
}

/* ---- rows ---- */

/* What is tried for a scheme, in order. */
typedef struct {
  row_maker *make;
  int degree;       /* of a fit; 0: the operator's */
  bool plain;       /* weight w whatever the operator says: w / r^2 suffers from near pairs */
  bool widens;      /* on wider supports too */
  bool settles;     /* the least unstable row so far is good enough now */
  bool is_fallback; /* not the scheme asked for */
} attempt;

enum { ATTEMPTS = 4 };
static const attempt attempts[][ATTEMPTS] = {
    [SCT_MPS] = {{row_mps, .widens = true}},
    [SCT_PS] = {{row_ps, .widens = true}},
    [SCT_IPS] = {{row_ips, .widens = true}},
    [SCT_IPSN] = {{row_ipsn},
                  {row_lsmps, 2, .widens = true, .is_fallback = true},
                  {row_lsmps, 2, .plain = true, .widens = true, .settles = true,
                   .is_fallback = true},
                  {row_ips, .widens = true, .is_fallback = true}},
    [SCT_LSMPS] = {{row_lsmps, .widens = true},
                   {row_lsmps, .plain = true, .widens = true, .settles = true},
                   {row_lsmps, 2, .plain = true, .widens = true, .settles = true,
                    .is_fallback = true},
                   {row_ips, .widens = true, .is_fallback = true}},
};

static const char *const complaints[ROW_VERDICTS] = {
    [ROW_TOO_FEW] = "are too few",
    [ROW_FLAT] = "lie on a line or a plane",
    [ROW_ILL] = "make the fit ill-conditioned",
    [ROW_UNSTABLE] = "give weights that are no good to solve with",
    [ROW_NO_DIFFUSION] = "lie on one side only",
    [ROW_CROWDED] =
        "are no good, with more than the limit of neighbours in the next wider support,",
};

static sct_status deficient(const sct_stencil *s, int64_t i, const row_job *job,
                            row_verdict verdict, sct_error *err) {
  char needs[64] = "";
  if (verdict == ROW_TOO_FEW) {
    const int64_t least = s->op.scheme == SCT_LSMPS
                              ? row_unknowns(s->cloud.dim, s->op.degree) + 1
                              : s->cloud.dim + ((job->want & SCT_ROW_LAPLACIAN) != 0);
    snprintf(needs, sizeof needs, ", needs %" PRId64, least);
  }
  return sct_fail(err, SCT_E_DEFICIENT, i,
                  "has %" PRId64 " neighbours within %.2f spacings, which %s for %s in %d-D%s",
                  job->n, job->support / s->spacing, complaints[verdict], schemes[s->op.scheme],
                  s->cloud.dim, needs);
}

/* The supports of an attempt: the operator's own (k = 0), then the wider ones beyond it. */
static double support_of(const sct_stencil *s, int k) {
  int next = 0;
  if (k == 0) return s->op.radius * s->spacing;
  while (next < WIDER_COUNT && WIDER[next] <= s->op.radius) next++;
  return next + k - 1 < WIDER_COUNT ? WIDER[next + k - 1] * s->spacing : 0;
}

/* The row so far that is least unstable, to be made again if nothing better comes. */
typedef struct {
  const attempt *by;
  double support, excess;
} candidate;

/* Makes the row of i by one attempt on one support. */
static sct_status make_row(const sct_stencil *s, int64_t i, const attempt *by, double support,
                           row_job *job, sct_row *row, row_verdict *verdict, sct_error *err) {
  bool crowded = false;
  if (s->reach != NULL) s->reach[i] = fmax(s->reach[i], support);
  const sct_status status = lay_out(s, i, support, job, &row->index, &crowded, err);
  if (status != SCT_OK) return status;
  if (crowded) {
    *verdict = ROW_CROWDED;
    return SCT_OK;
  }
  job->degree = by->degree > 0 ? by->degree : s->op.degree;
  job->weight = by->plain ? SCT_WEIGHT_KERNEL : s->op.weight;
  job->excess = 0;
  *verdict = by->make(job);
  row->n = job->n;
  row->gradient = job->room->gradient;
  row->laplacian = row->normal = job->room->laplacian;
  row->support = support;
  row->flags = (support > s->op.radius * s->spacing ? SCT_ROW_WIDENED : 0) |
               (by->is_fallback ? SCT_ROW_FALLBACK : 0) | (job->excess > 0 ? SCT_ROW_LOOSE : 0);
  return SCT_OK;
}

/* One attempt on the operator's support and, if it may, on the wider ones. */
static sct_status try_supports(const sct_stencil *s, int64_t i, const attempt *by, row_job *job,
                               candidate *best, sct_row *row, row_verdict *verdict,
                               sct_error *err) {
  double support = support_of(s, 0);
  for (int k = 1; support > 0; support = by->widens ? support_of(s, k++) : 0) {
    const sct_status status = make_row(s, i, by, support, job, row, verdict, err);
    if (status != SCT_OK || *verdict == ROW_ACCEPTED || *verdict == ROW_CROWDED) return status;
    if (*verdict == ROW_UNSTABLE && job->excess < best->excess) {
      *best = (candidate){by, support, job->excess};
    }
  }
  return SCT_OK;
}

/* The least unstable row, made again. */
static sct_status settle(const sct_stencil *s, int64_t i, const candidate *best, row_job *job,
                         sct_row *row, row_verdict *verdict, sct_error *err) {
  job->tolerated = best->excess;
  return make_row(s, i, best->by, best->support, job, row, verdict, err);
}

sct_status sct_stencil_row(const sct_stencil *s, int64_t i, const sct_row_request *request,
                           sct_room *room, sct_row *row, sct_error *err) {
  row_job job = {.op = &s->op,
                 .dim = s->cloud.dim,
                 .spacing = s->spacing,
                 .request = request,
                 .want = request->want,
                 .velocity = s->op.upwind == SCT_UPWIND_NONE ? NULL : request->velocity,
                 .room = room};
  candidate best = {.excess = LOOSE};
  row_verdict verdict = ROW_TOO_FEW;
  for (int a = 0; a < ATTEMPTS && attempts[s->op.scheme][a].make != NULL; a++) {
    const attempt *by = &attempts[s->op.scheme][a];
    sct_status status = try_supports(s, i, by, &job, &best, row, &verdict, err);
    if (status == SCT_OK && verdict != ROW_ACCEPTED && by->settles && best.by != NULL) {
      status = settle(s, i, &best, &job, row, &verdict, err);
    }
    if (status != SCT_OK || verdict == ROW_ACCEPTED) return status;
  }
  return deficient(s, i, &job, verdict, err);
}

/* ---- application ---- */

typedef struct {
  const sct_stencil *stencil;
  const double *field;
  double *smoothed, *gradient, *laplacian;
  uint8_t *flags; /* may be NULL */
} application;

static double weighted_difference(const sct_row *row, const double *weight, const double *field,
                                  int64_t i) {
  double sum = 0;
  for (int64_t k = 0; k < row->n; k++) sum += weight[k] * (field[row->index[k]] - field[i]);
  return sum;
}

/* sum w phi_j / sum w; the point's own value where it has no neighbours.   [H11] eq. 2 */
static void smooth_point(const application *to, int64_t i, sct_room *room) {
  const int32_t *index;
  const int64_t n = sct_stencil_gather(to->stencil, i, room, true, &index);
  double sum = 0, weights_sum = row_sum(n, room->w);
  for (int64_t k = 0; k < n; k++) sum += room->w[k] * to->field[index[k]];
  to->smoothed[i] = weights_sum > 0 ? sum / weights_sum : to->field[i];
}

static sct_status apply_point(void *context, int64_t i, sct_room *room, sct_error *err) {
  const application *to = context;
  const int dim = to->stencil->cloud.dim;
  const int want = (to->gradient != NULL ? SCT_ROW_GRADIENT : 0) |
                   (to->laplacian != NULL ? SCT_ROW_LAPLACIAN : 0);
  const sct_row_request request = {.want = want};
  sct_row row = {0};
  if (to->smoothed != NULL) smooth_point(to, i, room);
  if (to->flags != NULL) to->flags[i] = 0;
  if (want == 0) return SCT_OK;
  const sct_status status = sct_stencil_row(to->stencil, i, &request, room, &row, err);
  if (status != SCT_OK) return status;
  if (to->flags != NULL) to->flags[i] = (uint8_t)row.flags;
  for (int a = 0; to->gradient != NULL && a < dim; a++) {
    to->gradient[i * dim + a] = weighted_difference(&row, row.gradient + a * row.n, to->field, i);
  }
  if (to->laplacian != NULL) {
    to->laplacian[i] = weighted_difference(&row, row.laplacian, to->field, i);
  }
  return SCT_OK;
}

sct_status sct_stencil_apply(const sct_stencil *stencil, const double *field, const sct_work *work,
                             double *smoothed, double *gradient, double *laplacian,
                             sct_error *err) {
  return sct_stencil_apply_flagged(stencil, field, work, smoothed, gradient, laplacian, NULL, err);
}

sct_status sct_stencil_apply_flagged(const sct_stencil *stencil, const double *field,
                                     const sct_work *work, double *smoothed, double *gradient,
                                     double *laplacian, uint8_t *flags, sct_error *err) {
  application to = {stencil, field, smoothed, gradient, laplacian, flags};
  return sct_points_run(stencil, 0, stencil->cloud.n, work, apply_point, &to, err);
}
