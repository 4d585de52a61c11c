#include "study_compare.h"

#include <math.h>

/* Are the parameters of the run those of the reference? */
static bool applies(study_run *r, const doc *reference) {
  for (const doc *p = doc_member(reference, "parameters")->child; p; p = p->next) {
    const double value = scope_number(&r->names, p->key);
    if (!(fabs(value - p->number) <= 1e-9 * fabs(p->number))) return false;
  }
  return true;
}

/* At x the cubic through the four of n >= 4 ascending places around it. */
static double between(int64_t n, const double *s, const double *v, double x) {
  int64_t k = 1;
  double sum = 0;
  while (k < n - 3 && x > s[k + 1]) k++;
  for (int64_t a = k - 1; a < k + 3; a++) {
    double part = v[a];
    for (int64_t b = k - 1; b < k + 3; b++) {
      if (b != a) part *= (x - s[b]) / (s[a] - s[b]);
    }
    sum += part;
  }
  return sum;
}

/* Adds the squares of one curve; leaves out places beyond the result. */
static void add_curve(const doc *result, const doc *curve, double *sum, int64_t *count) {
  const doc *s = study_run_value(result, doc_member(curve, "places")->text);
  const doc *v = study_run_value(result, doc_member(curve, "values")->text);
  const doc *at = doc_member(curve, "at"), *known = doc_member(curve, "known");
  if (!s || !v || s->kind != DOC_NUMBERS || v->kind != DOC_NUMBERS || s->count < 4) return;
  for (int64_t k = 0; k < at->count; k++) {
    if (at->data[k] < s->data[0] || at->data[k] > s->data[s->count - 1]) continue;
    const double e = between(s->count, s->data, v->data, at->data[k]) - known->data[k];
    *sum += e * e;
    ++*count;
  }
}

static bool add_curves(study_run *r, const doc *result, const doc *curves, doc *members) {
  for (const doc *name = curves->child; name; name = name->next) {
    double sum = 0;
    int64_t count = 0;
    for (const doc *c = name->child; c; c = c->next) add_curve(result, c, &sum, &count);
    if (count == 0) continue;
    const double rms = sqrt(sum / (double)count);
    if (!doc_append(members, doc_make_number(&r->own, name->key, rms))) return false;
  }
  return true;
}

bool study_compare(study_run *r, const doc *result, doc *members) {
  const doc *references = doc_member(r->in->root, "references");
  for (const doc *one = references ? references->child : NULL; one; one = one->next) {
    if (!applies(r, one)) continue;
    const doc *known = doc_member(one, "numbers"), *curves = doc_member(one, "curves");
    if (known && !doc_append(members, doc_make_alias(&r->own, "reference", known))) return false;
    if (curves && !add_curves(r, result, curves, members)) return false;
  }
  scope_close(&r->names);
  return !r->own.error.code;
}
