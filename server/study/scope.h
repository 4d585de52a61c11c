/* scope.h - the names that the expressions of a study case know in one run: parameters of the case,
 * n (cells of the mesh), seed (of the cloud), and numbers derived of these.
 * Proof: http.study
 */
#ifndef SCATTERD_SCOPE_H
#define SCATTERD_SCOPE_H

#include "doc_make.h"
#include "expression.h"

typedef struct {
  task *t;           /* memory, and its failures */
  const doc *root;   /* the case */
  const doc *arrays; /* object: parameters, of which those that are arrays count */
  doc *names;        /* object of numbers */
  task words;        /* holds the language of the names */
} scope;

/* Begins one with the numbers among `parameters`, an object. Close it in any case. This and all
 * below fail only when out of memory (t->error). */
bool scope_open(task *t, const doc *root, const doc *parameters, scope *s);

/* Gives a name a value, or another one. */
bool scope_set(scope *s, const char *name, double value);

/* Adds the numbers that the case derives, in their order. Names must not change any more. */
bool scope_derive(scope *s);

/* Value of an expression of the case without coordinates; NaN on failure, too. */
double scope_number(scope *s, const char *text);

/* Values [n] of an expression of the case at points x [n][dim]. */
bool scope_numbers(scope *s, const char *text, int dim, const double *x, int64_t n, double *out);

void scope_close(scope *s);

/* The parameter of the case (or "n") that the value of `text` hangs on: the first named in it, or
 * in what is derived or in a field that it names. NULL if there is none. */
const char *scope_culprit(const doc *root, const char *text, char room[64]);

#endif
