#include "study_row.h"

#include <math.h>
#include <string.h>

#include "member.h"
#include "study_compare.h"

/* What a case takes */

/* A number within an array of numbers: {"laplacian": "/laplacian/1"}. */
static doc *number_within(task *t, const doc *result, const char *key, const char *pointer) {
  double value = doc_number_at(result, pointer);
  return isfinite(value) ? doc_make_number(t, key, value) : NULL;
}

/* An expression of the parameters and of the numbers of the row before it. */
static doc *computed(study_run *r, const doc *rule) {
  double value = scope_number(&r->names, rule->text);
  scope_close(&r->names);
  return isfinite(value) ? doc_make_number(&r->own, rule->key, value) : NULL;
}

static doc *take_object(study_run *r, const doc *result, const doc *rules);

/* The member that a rule makes; NULL if there is none. */
static doc *take(study_run *r, const doc *result, const doc *rule) {
  if (rule->kind == DOC_OBJECT) return take_object(r, result, rule);
  if (*rule->text != '/') return computed(r, rule);
  const doc *found = study_run_value(result, rule->text);
  if (found) return doc_make_alias(&r->own, rule->key, found);
  return number_within(&r->own, result, rule->key, rule->text);
}

static bool add_member(study_run *r, doc *members, doc *member) {
  if (!member) return !r->own.error.code;
  doc_append(members, member);
  return member->kind != DOC_NUMBER || scope_set(&r->names, member->key, member->number);
}

static doc *take_object(study_run *r, const doc *result, const doc *rules) {
  doc *members = doc_make_object(&r->own, rules->key);
  for (const doc *rule = rules->child; rule && members; rule = rule->next) {
    if (!add_member(r, members, take(r, result, rule))) return NULL;
  }
  return members;
}

/* Norms stand flat in the row. */
static bool take_norms(study_run *r, const doc *result, doc *members) {
  const doc *where = doc_member(r->in->root, "norms");
  const doc *norms = where ? study_run_value(result, where->text) : NULL;
  for (const doc *m = norms ? norms->child : NULL; m; m = m->next) {
    bool is_norm = strcmp(m->key, "points");
    if (is_norm && !doc_append(members, doc_make_alias(&r->own, m->key, m))) return false;
  }
  return true;
}

/* Sections: the solution at some of the points */

/* Keeps values [n] of one component where `chosen`; components lie `stride` apart. */
static doc *pick(task *t, const char *key, const double *value, int64_t stride,
                 const double *chosen, int64_t n) {
  double *kept = task_take(t, n, sizeof *kept);
  int64_t m = 0;
  for (int64_t k = 0; kept && k < n; k++) {
    if (chosen[k] != 0) kept[m++] = value[k * stride];
  }
  return kept ? doc_make_numbers(t, key, kept, m) : NULL;
}

static doc *take_section(study_run *r, const doc *result, const doc *rule) {
  static const char *const axes[] = {"x", "y", "z"};
  task *t = &r->own;
  const doc *points = study_run_value(result, "/points"),
            *solution = study_run_value(result, "/solution");
  const int64_t n = points->shape[0], dim = points->shape[1];
  double *chosen = task_take(t, n, sizeof *chosen);
  doc *section = doc_make_object(t, rule->key);
  if (!chosen || !section) return NULL;
  if (!scope_numbers(&r->names, rule->text, (int)dim, points->data, n, chosen)) return NULL;
  for (int64_t a = 0; a < dim && a < 3; a++) {
    if (!doc_append(section, pick(t, axes[a], points->data + a, dim, chosen, n))) return NULL;
  }
  return doc_append(section, pick(t, "value", solution->data, 1, chosen, n)) ? section : NULL;
}

static bool take_sections(study_run *r, const doc *result, doc *members) {
  const doc *sections = doc_member(r->in->root, "sections");
  for (const doc *rule = sections ? sections->child : NULL; rule; rule = rule->next) {
    if (!doc_append(members, take_section(r, result, rule))) return false;
  }
  return true;
}

/* All that the case takes from one result. */
static doc *members_of(study_run *r, const doc *result) {
  static const doc nothing = {.kind = DOC_OBJECT};
  const doc *rules = doc_member(r->in->root, "row");
  doc *members = doc_make_object(&r->own, NULL);
  if (!members || !take_norms(r, result, members)) return NULL;
  for (const doc *rule = (rules ? rules : &nothing)->child; rule; rule = rule->next) {
    if (!add_member(r, members, take(r, result, rule))) return NULL;
  }
  if (!take_sections(r, result, members) || !study_compare(r, result, members)) return NULL;
  return members;
}

/* The row */

/* Points of the run's cloud, or particles of its end. */
static int64_t points_of(const study_run *r, const doc *result) {
  const doc *particles = study_run_value(result, "/particles");
  if (r->own.cloud) return r->own.cloud->cloud.n;
  return particles && particles->kind == DOC_NUMBERS ? particles->shape[0] : 0;
}

bool study_row_add(task *t, study_run *r, const doc *result, study_row *row) {
  const doc *members = members_of(r, result);
  if (!members) {
    if (!t->error.code) t->error = r->own.error;
    return false;
  }
  row->runs++;
  if (row->members) {
    doc_mean(row->members, members, row->runs);
  } else {
    row->members = doc_mean_begin(t, members);
    row->points = points_of(r, result);
  }
  row->seconds += (stopwatch_total(&r->own.watch) - row->seconds) / (double)row->runs;
  return row->members;
}

/* Writing */

/* Order of convergence by the number of cells: ln(e0 / e1) / ln(n1 / n0). */
static double rate(const char *norm, const study_row *row, const study_row *before) {
  const doc *coarse = doc_member(before->members, norm), *fine = doc_member(row->members, norm);
  if (!coarse || !fine || row->cells == before->cells || row->value != before->value) return NAN;
  return log(coarse->number / fine->number) / log((double)row->cells / (double)before->cells);
}

void study_row_write(emit *e, const study_row *row, const study_row *before) {
  emit_object(e);
  member_integer(e, "cells", row->cells);
  if (row->varied) member_number(e, row->varied, row->value);
  member_integer(e, "points", row->points);
  for (const doc *m = row->members->child; m; m = m->next) {
    emit_key(e, m->key);
    emit_doc(e, m);
  }
  if (before) member_number(e, "rate_l2", rate("l2", row, before));
  if (before) member_number(e, "rate_linf", rate("linf", row, before));
  member_number(e, "seconds", row->seconds);
  if (row->paper->child) {
    emit_key(e, "paper");
    emit_doc(e, row->paper);
  }
  emit_end(e);
}
