#include "scope.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

static bool add(scope *s, const char *name, double value) {
  return doc_append(s->names, doc_make_number(s->t, name, value));
}

bool scope_open(task *t, const doc *root, const doc *parameters, scope *s) {
  *s = (scope){.t = t, .root = root, .arrays = parameters, .names = doc_make_object(t, NULL)};
  s->words.limits = t->limits;
  if (!s->names) return false;
  for (const doc *p = parameters->child; p; p = p->next) {
    if (p->kind == DOC_NUMBER && !add(s, p->key, p->number)) return false;
  }
  return true;
}

bool scope_set(scope *s, const char *name, double value) {
  doc *known = (doc *)doc_member(s->names, name);
  if (!known) return add(s, name, value);
  known->number = value;
  return true;
}

/* The expressions of a case are right, so one that fails had no memory. */
bool scope_numbers(scope *s, const char *text, int dim, const double *x, int64_t n, double *out) {
  expression e;
  expression_error error;
  s->words.parameters = s->names;
  language *l = language_of(&s->words);
  if (l && expression_check(l, text, dim, &e, &error) &&
      expression_evaluate(l, &e, dim, x, NULL, n, 0, out, 1)) {
    return true;
  }
  (void)sct_fail(&s->t->error, SCT_E_MEMORY, -1, "no memory for \"%.200s\"", text);
  return false;
}

double scope_number(scope *s, const char *text) {
  static const double nowhere[1];
  double value;
  return scope_numbers(s, text, 0, nowhere, 1, &value) ? value : NAN;
}

/* A language knows the names it began with, so each number derived begins a new one. */
bool scope_derive(scope *s) {
  const doc *derived = doc_member(s->root, "derived");
  for (const doc *d = derived ? derived->child : NULL; d; d = d->next) {
    if (!add(s, d->key, scope_number(s, d->text)) || s->t->error.code) return false;
    scope_close(s);
  }
  return true;
}

void scope_close(scope *s) {
  language_free(&s->words.language);
}

/* The name that begins at or after *text, in `room`; *text moves past it. False at the end. */
static bool next_name(const char **text, char room[64]) {
  const char *c = *text;
  while (*c && !isalpha((unsigned char)*c)) c++;
  size_t length = 0;
  while (isalnum((unsigned char)c[length]) || c[length] == '_') length++;
  *text = c + length;
  if (length == 0 || length >= 64) return false;
  memcpy(room, c, length);
  room[length] = '\0';
  return true;
}

/* Text of what the case derives, or of a field of it; NULL if there is none of that name. */
static const char *text_behind(const doc *root, const char *name) {
  const doc *derived = doc_member(doc_member(root, "derived"), name);
  const doc *field = doc_member(doc_member(root, "fields"), name);
  return derived ? derived->text : field ? field->text : NULL;
}

/* Recursion as deep as numbers of a case are derived from others. */
const char *scope_culprit(const doc *root, const char *text, char room[64]) {
  while (next_name(&text, room)) {
    if (!strcmp(room, "n") || doc_member(doc_member(root, "parameters"), room)) return room;
    const char *behind = text_behind(root, room);
    const char *found = behind ? scope_culprit(root, behind, room) : NULL;
    if (found) return found;
  }
  return NULL;
}
