#include "expression_slope.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
  STEPS = 20,  /* halvings at most: steps down to 1e-6 of the first */
  COLUMNS = 6, /* extrapolations: truncation up to h^12 */
  PATIENCE = 3 /* halvings without a better value anywhere */
};

/* Estimates not worth improving, relative to the derivative. */
static const double content = 1e-14;

typedef struct {
  task *t;
  const expression *e;
  const sites *on;
  double time;
  const char *name;
  double value;
  double *slope, *error;         /* [n] best so far, and its estimated error */
  double *row[COLUMNS], *before; /* [n] of the tableau */
} search;

/* out = e, the parameter moved by `by` */
static bool evaluate(const search *s, double by, double *out) {
  language *l = language_of(s->t);
  const cloud_input *c = s->on->cloud;
  if (!l) return false;
  language_set(l, s->name, s->value + by);
  bool done = expression_evaluate(l, s->e, c->cloud.dim, c->cloud.x, s->on->place, s->on->n,
                                  s->time, out, 1);
  language_set(l, s->name, s->value);
  if (!done) (void)sct_fail(&s->t->error, SCT_E_MEMORY, -1, "no room for a derivative");
  return done;
}

/* into = (e(p + h) - e(p - h)) / 2h, h being what the parameter really moves by */
static bool difference(const search *s, double h, double *into) {
  const double up = s->value + h - s->value, down = s->value - (s->value - h);
  double *below = s->before; /* free until the row is extended */
  if (!evaluate(s, up, into) || !evaluate(s, -down, below)) return false;
  for (int64_t k = 0; k < s->on->n; k++) into[k] = (into[k] - below[k]) / (up + down);
  return true;
}

/* Takes an extrapolation in where its two parents agree better than any pair before. */
static int64_t improve(const search *s, int64_t k, double better, double left, double above) {
  const double error = fmax(fabs(better - left), fabs(better - above));
  if (!(error < s->error[k])) return 0; /* nor if it is NaN */
  s->error[k] = error;
  s->slope[k] = better;
  return 1;
}

/* The next row of the tableau, d[0] = the new difference, d[j] = d[j-1] + (d[j-1] - old[j-1]) /
 * (4^j - 1), over the old one. Returns how many points gained by it. */
static int64_t extend(const search *s, int columns, const double *newest) {
  int64_t gained = 0;
  for (int64_t k = 0; k < s->on->n; k++) {
    double left = newest[k], power = 4;
    for (int j = 0; j < columns; j++, power *= 4) {
      const double above = s->row[j][k], better = left + (left - above) / (power - 1);
      s->row[j][k] = left;
      gained += improve(s, k, better, left, above);
      left = better;
    }
    if (columns < COLUMNS) s->row[columns][k] = left;
  }
  return gained;
}

/* Has every point a value, and one that is good enough? */
typedef enum { MISSING, ROUGH, CONTENT } verdict;
static verdict judge(const search *s) {
  verdict worst = CONTENT;
  for (int64_t k = 0; k < s->on->n; k++) {
    if (!(s->error[k] < INFINITY)) return MISSING;
    if (!(s->error[k] <= content * fabs(s->slope[k]))) worst = ROUGH;
  }
  return worst;
}

static bool run(search *s, double *newest) {
  double h = s->value != 0 ? 0.1 * fabs(s->value) : 0.1;
  for (int step = 0, idle = 0; step < STEPS && idle < PATIENCE; step++, h /= 2) {
    if (!difference(s, h, newest)) return false;
    const int64_t gained = extend(s, step < COLUMNS ? step : COLUMNS, newest);
    const verdict found = judge(s);
    if (step > 1 && found == CONTENT) return true;
    idle = gained > 0 || found == MISSING ? 0 : idle + 1;
  }
  return true;
}

static bool found_all(search *s) {
  for (int64_t k = 0; k < s->on->n; k++) {
    if (s->error[k] < INFINITY) continue;
    const int64_t point = s->on->place ? s->on->place[k] : k;
    (void)sct_fail(&s->t->error, SCT_E_NOT_FINITE, point,
                   "has no derivative of \"%.60s\" with respect to %.40s at %.15g", s->e->text,
                   s->name, s->value);
    return false;
  }
  return true;
}

bool expression_slope(task *t, const expression *e, const sites *on, double time, const char *name,
                      double value, double *slope) {
  search s = {t, e, on, time, name, value, .slope = slope};
  const int64_t n = on->n;
  double *block = malloc((size_t)(COLUMNS + 3) * (size_t)(n > 0 ? n : 1) * sizeof *block);
  if (!block) {
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no room for a derivative");
    return false;
  }
  s.error = block;
  s.before = block + n;
  for (int j = 0; j < COLUMNS; j++) s.row[j] = block + (3 + j) * n;
  for (int64_t k = 0; k < n; k++) s.error[k] = INFINITY;
  const bool good = run(&s, block + 2 * n) && found_all(&s);
  free(block);
  return good;
}
