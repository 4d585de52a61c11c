#include "refusal.h"

#include <stdio.h>
#include <string.h>

#include "cloud_input.h"

void refuse(reply *r, const problem *p) {
  r->status = p->status;
  r->coding = CODING_IDENTITY;
  snprintf(r->type, sizeof r->type, "%s", media_type(MEDIA_PROBLEM));
  problem_shorten(p, r->detail, sizeof r->detail);
  r->bytes = problem_bytes(p, &r->size);
}

/* HTTP status of a failure, and whether the text says what a client could do. */
static int status_of(sct_status code) {
  static const int statuses[SCT_STATUS_COUNT] = {
      [SCT_OK] = 500,           [SCT_E_ARGUMENT] = 400,
      [SCT_E_MEMORY] = 422,     [SCT_E_LIMIT] = 422,
      [SCT_E_NOT_FINITE] = 422, [SCT_E_COINCIDENT] = 400,
      [SCT_E_DEFICIENT] = 422,  [SCT_E_SINGULAR] = 422,
      [SCT_E_UNSTABLE] = 422,   [SCT_E_CONVERGENCE] = 422,
      [SCT_E_CANCELLED] = 503,
  };
  return statuses[code];
}

/* The culprit `point`, of posted points by its own pointer. */
static void add_point(problem *p, const cloud_input *c, int64_t point, const char *detail) {
  char pointer[PROBLEM_POINTER], where[96];
  const double *x = c->posted + point * c->cloud.dim;
  int used = snprintf(where, sizeof where, "%.6g", x[0]);
  for (int a = 1; a < c->cloud.dim; a++) {
    used += snprintf(where + used, sizeof where - (size_t)used, ", %.6g", x[a]);
  }
  snprintf(pointer, sizeof pointer, "%s", c->pointer);
  size_t end = strlen(pointer);
  if (!c->is_lattice) snprintf(pointer + end, sizeof pointer - end, "/%lld", (long long)point);
  problem_add(p, pointer, "point %lld at (%s): %s", (long long)point, where, detail);
}

/* All points of an error, as far as it keeps them. */
static void add_points(problem *p, const cloud_input *c, const sct_error *error) {
  int64_t kept = error->count < SCT_ERROR_POINTS ? error->count : SCT_ERROR_POINTS;
  for (int64_t k = 0; k < kept; k++) {
    bool is_subject = error->points[k] == error->point;
    const char *detail = is_subject ? error->text : sct_status_text(error->code);
    if (error->points[k] >= 0 && error->points[k] < c->cloud.n) {
      add_point(p, c, error->points[k], detail);
    }
  }
}

static void refuse_failure(reply *r, task *t) {
  char message[SCT_ERROR_TEXT + 256];
  problem p;
  sct_error *error = &t->error;
  if (t->cloud) cloud_input_translate(t->cloud, error);
  sct_error_message(error, message, sizeof message);
  if (error->code == SCT_E_MEMORY) {
    problem_begin(&p, status_of(error->code), "out of memory (%s), a worker may have %lld bytes",
                  message, (long long)t->limits->memory_bytes);
  } else {
    problem_begin(&p, status_of(error->code), "%s: %s", sct_status_text(error->code), message);
  }
  if (t->blame) problem_add(&p, t->blame, "%s", error->text);
  if (t->cloud) add_points(&p, t->cloud, error);
  if (p.count == 0 && p.status == 400) problem_add(&p, "/inputs", "%s", message);
  refuse(r, &p);
}

/* The detail of all is that of the first, and how many more there are. */
static void refuse_complaints(reply *r, task *t) {
  problem *all = &t->complaints;
  const char *pointer = all->errors[0].pointer;
  char more[32] = "";
  problem p;
  if (all->found > 1) snprintf(more, sizeof more, " (and %d more)", all->found - 1);
  problem_begin(&p, 400, "%s: %s%s", *pointer ? pointer : "the body", all->errors[0].detail, more);
  memcpy(all->detail, p.detail, sizeof p.detail);
  all->status = p.status;
  all->type = p.type;
  refuse(r, all);
}

void refuse_task(reply *r, task *t) {
  if (t->complaints.found > 0) {
    refuse_complaints(r, t);
  } else {
    refuse_failure(r, t);
  }
}
