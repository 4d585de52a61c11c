#include "template.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "member.h"

/* Filling in */

static const char *text_of(const doc *place, const char *member) {
  const doc *text = doc_member(place, member);
  return text ? text->text : NULL;
}

static void write_array(emit *e, const doc *place, const doc *array, scope *s) {
  const char *most = text_of(place, "most");
  const double limit = most ? scope_number(s, most) : INFINITY;
  emit_list(e);
  for (int64_t k = 0; k < array->count; k++) {
    if (!(array->data[k] > limit)) emit_number(e, array->data[k]);
  }
  emit_end(e);
}

static void write_integers(emit *e, double first, double last) {
  emit_list(e);
  for (double k = first; k <= last; k++) emit_number(e, k);
  emit_end(e);
}

static void write_place(emit *e, const doc *place, scope *s) {
  const char *text = text_of(place, "="), *last = text_of(place, "to");
  const doc *array = doc_member(s->arrays, text);
  const char *field = text_of(doc_member(s->root, "fields"), text);
  if (field) {
    emit_text(e, field);
  } else if (array && array->kind == DOC_NUMBERS && !doc_member(s->names, text)) {
    write_array(e, place, array, s);
  } else if (last) {
    write_integers(e, scope_number(s, text), scope_number(s, last));
  } else {
    emit_number(e, scope_number(s, text));
  }
}

static void write_children(emit *e, const doc *container, scope *s) {
  for (const doc *d = container->child; d; d = d->next) {
    if (d->key) emit_key(e, d->key);
    template_write(e, d, s);
  }
  emit_end(e);
}

/* Recursion as deep as a case file. */
void template_write(emit *e, const doc *template, scope *s) {
  if (doc_member(template, "=")) {
    write_place(e, template, s);
  } else if (template->kind == DOC_OBJECT) {
    emit_object(e);
    write_children(e, template, s);
  } else if (template->kind == DOC_LIST) {
    emit_list(e);
    write_children(e, template, s);
  } else {
    emit_doc(e, template);
  }
}

/* Blame */

/* The first place to fill in within `d`, itself or below. */
static const doc *first_place(const doc *d) {
  if (doc_member(d, "=")) return d;
  for (const doc *child = d->child; child; child = child->next) {
    const doc *place = first_place(child);
    if (place) return place;
  }
  return NULL;
}

/* The place that the pointer leads to or into; *rest is what it goes on with. */
static const doc *place_at(const doc *d, const char *pointer, const char **rest) {
  char step[PROBLEM_POINTER];
  while (d && *pointer == '/' && !doc_member(d, "=")) {
    size_t length = strcspn(pointer + 1, "/") + 1;
    snprintf(step, sizeof step, "%.*s", (int)length, pointer);
    const doc *child = doc_at_pointer(d, step);
    if (!child) break;
    d = child;
    pointer += length;
  }
  *rest = pointer;
  return d ? first_place(d) : NULL;
}

void template_blame(const doc *root, const doc *template, const char *pointer, int64_t mesh,
                    char blamed[PROBLEM_POINTER]) {
  static const char inputs[] = "/inputs", own[] = "/inputs/operator";
  const char *rest = "", *culprit = NULL;
  char room[64];
  if (!strncmp(pointer, own, strlen(own))) {
    snprintf(blamed, PROBLEM_POINTER, "%s", pointer);
    return;
  }
  if (!strncmp(pointer, inputs, strlen(inputs))) {
    const doc *place = place_at(template, pointer + strlen(inputs), &rest);
    if (place) culprit = scope_culprit(root, text_of(place, "="), room);
  }
  if (!culprit || !strcmp(culprit, "n")) { /* nothing but the mesh is left to differ */
    snprintf(blamed, PROBLEM_POINTER, "%s/cells/%lld", inputs, (long long)mesh);
  } else {
    const doc *known = doc_member(doc_member(root, "parameters"), culprit);
    bool is_array = !strcmp(text_of(known, "type"), "array");
    snprintf(blamed, PROBLEM_POINTER, "%s/parameters/%s%.64s", inputs, culprit,
             is_array ? rest : "");
  }
}
