#include "study_paper.h"

#include <math.h>
#include <string.h>

#include "member.h"

static const doc *columns_of(const study_input *in) {
  const doc *columns = doc_member(in->root, "columns");
  return columns ? columns->child : NULL;
}

int64_t study_paper_columns(const study_input *in) {
  const doc *columns = doc_member(in->root, "columns");
  return columns ? columns->count : 0;
}

static bool is_near(double a, double b) {
  return fabs(a - b) <= 1e-9 * fabs(b);
}

static bool operators_agree(const sct_operator *a, const sct_operator *b) {
  bool is_fit = a->scheme == SCT_LSMPS, is_published = a->upwind == SCT_UPWIND_PUBLISHED;
  return a->scheme == b->scheme && a->kernel == b->kernel && is_near(a->radius, b->radius) &&
         a->density == b->density && a->upwind == b->upwind &&
         (!is_fit || (a->degree == b->degree && a->weight == b->weight)) &&
         (!is_published || (is_near(a->gamma_scale, b->gamma_scale) &&
                            is_near(a->reference_length, b->reference_length) &&
                            is_near(a->reference_speed, b->reference_speed)));
}

/* Every parameter that is a number must be the column's, or else the default; seeds have no part in
 * what was printed. */
static bool parameters_agree(const study_input *in, int64_t k, const doc *column) {
  const doc *own = doc_member(column, "parameters"), *known = doc_member(in->root, "parameters");
  for (const doc *p = in->parameters->child; p; p = p->next) {
    const doc *asked = doc_member(own, p->key);
    const doc *wanted = asked ? asked : doc_member(doc_member(known, p->key), "default");
    bool is_varied = in->varied && !strcmp(in->varied->key, p->key);
    double value = is_varied ? in->varied->data[k / in->cells.rows] : p->number;
    if (wanted->kind != DOC_NUMBER || !strncmp(p->key, "seed", 4)) continue;
    if (!is_near(value, wanted->number)) return false;
  }
  return true;
}

/* Place of the row's mesh in the column, -1 if it has none. */
static int64_t place_of(const doc *column, int64_t cells) {
  const doc *meshes = doc_member(column, "cells");
  for (int64_t k = 0; k < meshes->count; k++) {
    if (meshes->data[k] == (double)cells) return k;
  }
  return -1;
}

bool study_paper_find(task *t, const study_input *in, int64_t k, study_row *row, bool *used) {
  int64_t c = 0;
  row->paper = doc_make_object(t, NULL);
  if (!row->paper) return false;
  for (const doc *column = columns_of(in); column; column = column->next, c++) {
    sct_operator op;
    int64_t place = place_of(column, row->cells);
    if (place < 0 || !parameters_agree(in, k, column)) continue;
    if (!study_input_operator(t, in, doc_member(column, "operator"), &op)) return false;
    if (!operators_agree(&in->op, &op)) continue;
    const char *member = doc_member(column, "member")->text;
    const double printed = doc_member(column, "printed")->data[place];
    if (!doc_append(row->paper, doc_make_number(t, member, printed))) return false;
    used[c] = true;
  }
  return true;
}

void study_paper_write(emit *e, const study_input *in, const bool *used) {
  static const char *const texts[] = {"title", "equation", "source", "where"};
  int64_t c = 0;
  emit_object(e);
  member_text(e, "case", in->name);
  for (int k = 0; k < 4; k++) member_text(e, texts[k], doc_member(in->root, texts[k])->text);
  emit_key(e, "notes");
  emit_doc(e, doc_member(in->root, "notes"));
  emit_key(e, "columns");
  emit_list(e);
  for (const doc *column = columns_of(in); column; column = column->next, c++) {
    if (used[c]) emit_doc(e, column);
  }
  emit_end(e);
  emit_end(e);
}
