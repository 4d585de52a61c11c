/* The rows of one part: the assembly of the whole on a smaller cloud, in which the halo is given.
 *
 * How far a row looks is known only when it is made, as deficient neighbourhoods are widened: rows
 * are made, and again with a wider halo as long as some row looked beyond it. A row that looked
 * only where the halo is complete has seen what it would have seen in the whole cloud. */
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "assemble_part.h"
#include "scatter/partition.h"
#include "scatter/search.h"

typedef struct {
  const sct_part_problem *problem;
  int k;
  const sct_work *work;
  sct_part *part;
  double *reach; /* [n of the whole] of own points: as far as the halo is complete */
  double *seen;  /* [n of the part] as far as rows looked */
  double *nearest;
  /* the problem's data at the points of the part */
  sct_fields fields;
  sct_boundary boundary;
  double *values;     /* owns them */
  uint8_t *condition; /* [n of the part] halo points are given */
  sct_search *search;
  sct_stencil *stencil;
  sct_system *system;
} part_job;

/* Everything that depends on the halo. */
static void drop_part(part_job *job) {
  sct_system_free(&job->system);
  sct_stencil_free(&job->stencil);
  sct_search_free(&job->search);
  sct_release(&job->condition);
  sct_release(&job->values);
  sct_release(&job->nearest);
  sct_release(&job->seen);
  sct_part_free(&job->part);
}

/* ---- data ---- */

/* The values of [n of the whole][width] at the points of the part, behind *next, NULL for NULL. */
static const double *pick(const sct_part *part, const double *from, int width, double **next) {
  double *const to = *next;
  if (from == NULL) return NULL;
  for (int64_t m = 0; m < part->n; m++) {
    memcpy(to + m * width, from + (int64_t)part->point[m] * width, (size_t)width * sizeof *to);
  }
  *next += part->n * width;
  return to;
}

static sct_status pick_data(part_job *job, sct_error *err) {
  const sct_fields *f = job->problem->fields;
  const sct_boundary *b = job->problem->boundary;
  const sct_part *part = job->part;
  const int dim = part->cloud.dim;
  sct_status status = sct_alloc(&job->values, part->n * (2 * dim + 5), sizeof *job->values, err);
  if (status == SCT_OK) status = sct_alloc(&job->condition, part->n, 1, err);
  if (status != SCT_OK) return status;
  double *next = job->values;
  job->fields = (sct_fields){.velocity = pick(part, f->velocity, dim, &next),
                             .diffusivity = pick(part, f->diffusivity, 1, &next),
                             .source = pick(part, f->source, 1, &next),
                             .reaction = pick(part, f->reaction, 1, &next)};
  for (int64_t m = 0; m < part->n; m++) {
    job->condition[m] = part->is_own[m] ? b->condition[part->point[m]] : SCT_DIRICHLET;
  }
  job->boundary = (sct_boundary){.condition = job->condition,
                                 .value = pick(part, b->value, 1, &next),
                                 .coefficient = pick(part, b->coefficient, 1, &next),
                                 .normal = pick(part, b->normal, dim, &next)};
  return SCT_OK;
}

/* ---- rows ---- */

static bool diffuses(const part_job *job) {
  const double *mu = job->problem->fields->diffusivity;
  for (int64_t i = 0; i < job->problem->cloud->n; i++) {
    if (mu[i] > 0) return true;
  }
  return false;
}

static sct_status make_rows(part_job *job, sct_error *err) {
  const sct_part_problem *p = job->problem;
  const sct_cloud *cloud = &job->part->cloud;
  sct_status status = sct_alloc_zero(&job->seen, cloud->n, sizeof *job->seen, err);
  if (status == SCT_OK) status = sct_alloc(&job->nearest, cloud->n, sizeof(double), err);
  if (status == SCT_OK) {
    status = sct_search_build(cloud, p->op->radius * p->spacing, SCT_SEARCH_AUTO, job->work,
                              &job->search, err);
  }
  if (status == SCT_OK) status = sct_search_nearest(job->search, job->work, job->nearest, err);
  if (status == SCT_OK) {
    status = sct_stencil_build(cloud, job->search, p->spacing, p->op, p->limit, job->work,
                               &job->stencil, err);
  }
  if (status != SCT_OK) return status;
  sct_stencil_note_reach(job->stencil, job->seen);
  return sct_system_build_part(job->stencil, &job->fields, &job->boundary, diffuses(job), job->work,
                               &job->system, err);
}

/* Did a row look beyond the halo? Then that is to reach as far. */
static bool widen(part_job *job) {
  bool more = false;
  for (int64_t m = 0; job->seen != NULL && m < job->part->n; m++) {
    double *const reach = &job->reach[job->part->point[m]];
    if (!job->part->is_own[m] || !(job->seen[m] > *reach)) continue;
    *reach = job->seen[m];
    more = true;
  }
  return more;
}

/* Has the part what a wider halo would give it? */
static sct_status grow(part_job *job, double width, bool *is_larger, sct_error *err) {
  sct_part *larger = NULL;
  sct_status status = sct_part_build(job->problem->cloud, job->problem->partition, job->k, width,
                                     job->reach, job->work, &larger, err);
  if (status != SCT_OK) return status;
  *is_larger = larger->n > job->part->n;
  if (*is_larger) {
    drop_part(job);
    job->part = larger;
  } else {
    sct_part_free(&larger);
  }
  return SCT_OK;
}

/* A part whose unknowns are all given has no rows; the library calls that an error. */
static bool has_unknowns(const part_job *job) {
  for (int64_t m = 0; m < job->part->n; m++) {
    if (job->condition[m] != SCT_DIRICHLET) return true;
  }
  return false;
}

static sct_status make_part(part_job *job, int *rounds, sct_error *err) {
  const sct_part_problem *p = job->problem;
  const double width = p->op->radius * p->spacing;
  bool again = true;
  for (int64_t i = 0; i < p->cloud->n; i++) job->reach[i] = width;
  sct_status status =
      sct_part_build(p->cloud, p->partition, job->k, width, NULL, job->work, &job->part, err);
  if (status != SCT_OK) return status;
  for (*rounds = 1; again; *rounds += again) {
    sct_error why = {.code = SCT_OK};
    status = pick_data(job, err);
    if (status != SCT_OK || !has_unknowns(job)) return status;
    const sct_status made = make_rows(job, &why);
    again = false;
    if ((made == SCT_OK || made == SCT_E_DEFICIENT) && widen(job)) {
      status = grow(job, width, &again, err);
      if (status != SCT_OK) return status;
    }
    if (!again && made != SCT_OK) {
      if (err != NULL) *err = why;
      return made;
    }
  }
  return SCT_OK;
}

/* ---- numbers ---- */

/* Unknowns are numbered along the curve. */
static sct_status number_unknowns(const part_job *job, sct_part_system *s, sct_error *err) {
  const sct_partition *p = job->problem->partition;
  const uint8_t *condition = job->problem->boundary->condition;
  const int64_t first = sct_partition_start(p, job->k);
  int32_t *number = NULL; /* [n of the whole] */
  sct_status status = sct_alloc(&number, p->n, sizeof *number, err);
  if (status == SCT_OK) status = sct_alloc(&s->number, s->part->n, sizeof *s->number, err);
  for (int64_t place = 0; status == SCT_OK && place < p->n; place++) {
    const int32_t point = sct_partition_point(p, place);
    if (place == first) s->first = s->unknowns;
    number[point] = condition[point] == SCT_DIRICHLET ? -1 : (int32_t)s->unknowns++;
  }
  if (first == p->n) s->first = s->unknowns;
  for (int64_t m = 0; status == SCT_OK && m < s->part->n; m++) {
    s->number[m] = number[s->part->point[m]];
  }
  sct_release(&number);
  return status;
}

/* From the part's numbers to those of the whole. */
static void translate(const sct_part *part, sct_error *err) {
  if (err == NULL || part == NULL) return;
  if (err->point >= 0 && err->point < part->n) err->point = part->point[err->point];
  for (int64_t k = 0; k < err->count && k < SCT_ERROR_POINTS; k++) {
    err->points[k] = part->point[err->points[k]];
  }
}

static double widest(const part_job *job) {
  double most = 0;
  for (int64_t m = 0; m < job->part->n; m++) {
    if (job->part->is_own[m] && job->seen != NULL) most = fmax(most, job->seen[m]);
  }
  return most;
}

sct_status sct_part_assemble(const sct_part_problem *problem, int k, const sct_work *work,
                             sct_part_system **out, sct_error *err) {
  part_job job = {.problem = problem, .k = k, .work = work};
  sct_part_system *s = NULL;
  *out = NULL;
  if (problem->op->upwind == SCT_UPWIND_LIMITED) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "upwind limited is not assembled in parts");
  }
  sct_status status = sct_alloc_zero(&s, 1, sizeof *s, err);
  if (status == SCT_OK) status = sct_alloc(&job.reach, problem->cloud->n, sizeof(double), err);
  if (status == SCT_OK) {
    status = make_part(&job, &s->rounds, err);
    if (status != SCT_OK && status != SCT_E_MEMORY) translate(job.part, err);
  }
  if (status == SCT_OK) {
    s->wide = widest(&job);
    s->part = job.part;
    s->system = job.system;
    job.part = NULL;
    job.system = NULL;
    status = number_unknowns(&job, s, err);
    if (status == SCT_OK && s->unknowns == 0) {
      status = sct_fail(err, SCT_E_ARGUMENT, -1, "every point has a given value, nothing to solve");
    }
  }
  drop_part(&job);
  sct_release(&job.reach);
  if (status != SCT_OK) sct_part_system_free(&s);
  *out = s;
  return status;
}

void sct_part_system_free(sct_part_system **system) {
  if (*system == NULL) return;
  sct_system_free(&(*system)->system);
  sct_part_free(&(*system)->part);
  sct_release(&(*system)->number);
  sct_release(system);
}
