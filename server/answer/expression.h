/* expression.h - expressions in fields, such as "1 + tanh(10*(2*x+1))". The only door to muParser.
 *
 * Names      x, y, z as far as the cloud has dimensions, t (time), pi, and the request's parameters
 * Operators  + - * / ^ (to the right: 2^3^2 = 512, -2^2 = -4), == != < <= > >= && || (1 or 0),
 *            condition ? a : b
 * Functions  of the C library's <math.h>, angles in radians: sin cos tan asin acos atan atan2(y, x)
 *            sinh cosh tanh asinh acosh atanh exp exp2 expm1 log (natural) ln log10 log2 log1p sqrt
 *            cbrt hypot(a, b) pow(a, b) fmod(a, b) abs floor ceil round trunc erf erfc gamma lgamma
 *            and sign(a) (-1, 0 or 1), step(a) (1 for a >= 0, else 0), min(a, ...), max(a, ...)
 * Proof: unit.expression
 */
#ifndef SCATTERD_EXPRESSION_H
#define SCATTERD_EXPRESSION_H

#include "task.h"

/* A parser that knows the names above and the numbers in t->parameters, made at its first use and
 * kept in t->language. NULL when out of memory (t->error). */
language *language_of(task *t);
void language_free(language **l);

/* Gives a parameter another value, for evaluations to come. */
void language_set(language *l, const char *name, double value);

/* Is `name` one that parameters cannot have: a variable, pi or a function? And the names, NULL at
 * the end. */
bool expression_is_reserved(const char *name);
/* A letter, then letters, digits and underscores; EXPRESSION_NAME with the NUL at most. */
enum { EXPRESSION_NAME = 64 };
bool expression_is_name(const char *name);

typedef struct {
  const char *text;
  bool varies;        /* with t */
  int64_t operations; /* operators and functions: what an evaluation at a point costs */
} expression;

/* Does the name stand in it? */
bool expression_names(const expression *e, const char *name);

/* Where and why an expression is not understood. */
typedef struct {
  int64_t position; /* character, from 1 */
  char text[160];
} expression_error;

/* Checks `text` as an expression on a cloud of dimension dim. False with `error` filled. Cost: one
 * parse. */
bool expression_check(language *l, const char *text, int dim, expression *e,
                      expression_error *error);

/* out[k * stride] = e at (x[point(k)], t) for k < m, point(k) = place ? place[k] : k, x [.][dim].
 * `e` must have passed the check. False when out of memory. Cost: a parse and some 20 ns per
 * operation and point. */
bool expression_evaluate(language *l, const expression *e, int dim, const double *x,
                         const int32_t *place, int64_t m, double time, double *out, int stride);

#endif
