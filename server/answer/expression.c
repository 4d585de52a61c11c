/* muParser reads the grammar; names are looked at here first, because its own messages do not say
 * what is known, and because it would take "x = 1" for an assignment. Its built-in functions are
 * cleared: what an expression means is the table below and nothing else.
 *
 * A bulk evaluation parses anew each time, so it runs over blocks that are long against a parse
 * and short against a cache; few points of an expression that has just been parsed are evaluated
 * one by one instead. */
#include "expression.h"

#include <ctype.h>
#include <math.h>
#include <muParserDLL.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _OPENMP
#include <omp.h>
#endif

#include "read.h"

enum { BLOCK = 8192, FEW = 160 };

/* The variables, by column: x y z t. */
enum { TIME = 3, VARIABLES = 4 };
static const char *const variable_names[VARIABLES] = {"x", "y", "z", "t"};

struct language {
  muParserHandle_t parser;
  const doc *parameters;
  const char *loaded;              /* text the parser holds parsed, or NULL */
  double column[VARIABLES][BLOCK]; /* values of the variables, point by point */
  double result[BLOCK];
};

/* Functions */

static double sign(double a) {
  return (a > 0) - (a < 0);
}

static double step(double a) {
  return a >= 0;
}

static double least(const double *a, int n) {
  double value = a[0];
  for (int k = 1; k < n; k++) value = fmin(value, a[k]);
  return value;
}

static double greatest(const double *a, int n) {
  double value = a[0];
  for (int k = 1; k < n; k++) value = fmax(value, a[k]);
  return value;
}

/* name, function of one number, of two, of any number of them: one of the three */
typedef struct {
  const char *name;
  double (*of_one)(double);
  double (*of_two)(double, double);
  double (*of_many)(const double *, int);
} function;

static const function functions[] = {
    {"sin", sin, NULL, NULL},           {"cos", cos, NULL, NULL},     {"tan", tan, NULL, NULL},
    {"asin", asin, NULL, NULL},         {"acos", acos, NULL, NULL},   {"atan", atan, NULL, NULL},
    {"sinh", sinh, NULL, NULL},         {"cosh", cosh, NULL, NULL},   {"tanh", tanh, NULL, NULL},
    {"asinh", asinh, NULL, NULL},       {"acosh", acosh, NULL, NULL}, {"atanh", atanh, NULL, NULL},
    {"exp", exp, NULL, NULL},           {"exp2", exp2, NULL, NULL},   {"expm1", expm1, NULL, NULL},
    {"log", log, NULL, NULL},           {"ln", log, NULL, NULL},      {"log10", log10, NULL, NULL},
    {"log2", log2, NULL, NULL},         {"log1p", log1p, NULL, NULL}, {"sqrt", sqrt, NULL, NULL},
    {"cbrt", cbrt, NULL, NULL},         {"abs", fabs, NULL, NULL},    {"floor", floor, NULL, NULL},
    {"ceil", ceil, NULL, NULL},         {"round", round, NULL, NULL}, {"trunc", trunc, NULL, NULL},
    {"erf", erf, NULL, NULL},           {"erfc", erfc, NULL, NULL},   {"gamma", tgamma, NULL, NULL},
    {"lgamma", lgamma, NULL, NULL},     {"sign", sign, NULL, NULL},   {"step", step, NULL, NULL},
    {"atan2", NULL, atan2, NULL},       {"pow", NULL, pow, NULL},     {"hypot", NULL, hypot, NULL},
    {"fmod", NULL, fmod, NULL},         {"min", NULL, NULL, least},   {"max", NULL, NULL, greatest},
    {"fabs", fabs, NULL, NULL},         {"fmin", NULL, fmin, NULL},   {"fmax", NULL, fmax, NULL},
    {"tgamma", tgamma, NULL, NULL},     {"fdim", NULL, fdim, NULL},   {"rint", rint, NULL, NULL},
    {"copysign", NULL, copysign, NULL},
};
enum { FUNCTIONS = sizeof functions / sizeof *functions };

static bool is_function(const char *name) {
  for (int k = 0; k < FUNCTIONS; k++) {
    if (!strcmp(functions[k].name, name)) return true;
  }
  return false;
}

static int variable_of(const char *name) {
  for (int k = 0; k < VARIABLES; k++) {
    if (!strcmp(variable_names[k], name)) return k;
  }
  return -1;
}

bool expression_is_reserved(const char *name) {
  return variable_of(name) >= 0 || !strcmp(name, "pi") || is_function(name);
}

static bool is_name_start(char c) {
  return isalpha((unsigned char)c) || c == '_';
}

static bool is_name_char(char c) {
  return isalnum((unsigned char)c) || c == '_';
}

bool expression_is_name(const char *name) {
  size_t length = 0;
  if (!isalpha((unsigned char)*name)) return false;
  while (is_name_char(name[length])) length++;
  return name[length] == '\0' && length < EXPRESSION_NAME;
}

/* The parser */

static void define_functions(muParserHandle_t parser) {
  for (int k = 0; k < FUNCTIONS; k++) {
    const function *f = &functions[k];
    if (f->of_one) mupDefineFun1(parser, f->name, f->of_one, 1);
    if (f->of_two) mupDefineFun2(parser, f->name, f->of_two, 1);
    if (f->of_many) mupDefineMultFun(parser, f->name, f->of_many, 1);
  }
}

static void define_constants(muParserHandle_t parser, const doc *parameters) {
  mupDefineConst(parser, "pi", 3.14159265358979323846);
  for (const doc *p = parameters ? parameters->child : NULL; p; p = p->next) {
    if (p->kind == DOC_NUMBER) mupDefineConst(parser, p->key, p->number);
  }
}

static language *language_new(const doc *parameters, int threads) {
  language *l = malloc(sizeof *l);
  if (!l) return NULL;
  l->parser = mupCreate(muBASETYPE_FLOAT);
  l->parameters = parameters;
  l->loaded = NULL;
  for (int k = 0; k < VARIABLES; k++)
    l->column[k][0] = 0; /* the rest is written before it is read */
#ifdef _OPENMP
  omp_set_num_threads(threads); /* muParser shares a bulk evaluation among them */
#else
  (void)threads;
#endif
  if (!l->parser) {
    free(l);
    return NULL;
  }
  mupClearFun(l->parser);
  mupClearConst(l->parser);
  define_functions(l->parser);
  define_constants(l->parser, parameters);
  for (int k = 0; k < VARIABLES; k++) mupDefineVar(l->parser, variable_names[k], l->column[k]);
  return l;
}

language *language_of(task *t) {
  if (!t->language) t->language = language_new(t->parameters, t->work.threads);
  if (!t->language)
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no room for the data of the request");
  return t->language;
}

void language_free(language **l) {
  if (!*l) return;
  mupRelease((*l)->parser);
  free(*l);
  *l = NULL;
}

void language_set(language *l, const char *name, double value) {
  mupDefineConst(l->parser, name, value);
  l->loaded = NULL; /* it holds the value before */
}

/* Check */

static bool fail(expression_error *error, int64_t position, const char *format, ...)
    SCT_PRINTF(3, 4);
static bool fail(expression_error *error, int64_t position, const char *format, ...) {
  va_list list;
  va_start(list, format);
  vsnprintf(error->text, sizeof error->text, format, list);
  va_end(list);
  error->position = position;
  return false;
}

/* The known name closest to `name`, or NULL. */
static const char *suggest(const language *l, const char *name, int dim) {
  enum { KNOWN_MAX = 128 };
  const char *known[KNOWN_MAX + 1];
  int n = 0;
  for (int k = 0; k < FUNCTIONS; k++) known[n++] = functions[k].name;
  for (int k = 0; k < VARIABLES; k++) {
    if (k < dim || k == TIME) known[n++] = variable_names[k];
  }
  known[n++] = "pi";
  for (const doc *p = l->parameters ? l->parameters->child : NULL; p; p = p->next) {
    if (n < KNOWN_MAX) known[n++] = p->key;
  }
  known[n] = NULL;
  return nearest_name(name, known);
}

static bool unknown_name(const language *l, const char *name, int dim, int64_t position,
                         expression_error *error) {
  const char *near = suggest(l, name, dim);
  char room[SHOWN_MAX], second[SHOWN_MAX];
  if (near) {
    return fail(error, position, "unknown name \"%s\"; did you mean \"%s\"?", shown(name, room),
                shown(near, second));
  }
  return fail(error, position,
              "unknown name \"%s\", needs a coordinate, t, pi, a parameter or a function",
              shown(name, room));
}

static bool name_is_known(const language *l, const char *name, int dim, int64_t position,
                          expression *e, expression_error *error) {
  int variable = variable_of(name);
  if (variable >= dim && variable != TIME) {
    return fail(error, position, "%s does not exist in %d-D", name, dim);
  }
  if (variable == TIME) e->varies = true;
  if (variable >= 0 || !strcmp(name, "pi") || is_function(name)) return true;
  if (doc_member(l->parameters, name)) return true;
  return unknown_name(l, name, dim, position, error);
}

/* Past a number such as 1.5e-3. */
static const char *skip_number(const char *c) {
  while (isdigit((unsigned char)*c) || *c == '.') c++;
  if (*c != 'e' && *c != 'E') return c;
  const char *digits = c[1] == '+' || c[1] == '-' ? c + 2 : c + 1;
  if (!isdigit((unsigned char)*digits)) return c;
  while (isdigit((unsigned char)*digits)) digits++;
  return digits;
}

bool expression_names(const expression *e, const char *name) {
  const size_t length = strlen(name);
  for (const char *c = e->text; *c;) {
    const char *word = c;
    if (isdigit((unsigned char)*c) || *c == '.') {
      c = skip_number(c);
    } else if (is_name_start(*c)) {
      while (is_name_char(*c)) c++;
      if ((size_t)(c - word) == length && !memcmp(word, name, length)) return true;
    } else {
      c++;
    }
  }
  return false;
}

static bool is_comparison(const char *text, const char *c) {
  return c[1] == '=' || (c > text && strchr("<>!=", c[-1]));
}

/* One character that is neither in a number nor in a name. */
static bool character_is_known(const char *text, const char *c, expression_error *error) {
  int64_t position = c - text + 1;
  if (*c == '=' && !is_comparison(text, c)) {
    return fail(error, position, "\"=\" cannot assign, needs == to compare");
  }
  if (*c == '*' && c[1] == '*')
    return fail(error, position, "\"**\" is no operator, powers need ^");
  if (strchr("+-*/^()<>=!?:,&| \t\r\n", *c)) return true;
  if (!isprint((unsigned char)*c)) return fail(error, position, "unknown character");
  return fail(error, position, "unknown character \"%c\"", *c);
}

/* Every name and character of the text, from left to right. */
static bool words_are_known(const language *l, const char *text, int dim, expression *e,
                            expression_error *error) {
  char name[EXPRESSION_NAME];
  for (const char *c = text; *c;) {
    const char *word = c;
    if (isdigit((unsigned char)*c) || *c == '.') {
      c = skip_number(c);
    } else if (is_name_start(*c)) {
      while (is_name_char(*c)) c++;
      snprintf(name, sizeof name, "%.*s", (int)(c - word), word);
      if (!name_is_known(l, name, dim, word - text + 1, e, error)) return false;
      if (is_function(name) && c[strspn(c, " \t\r\n")] != '(') {
        return fail(error, word - text + 1, "function without arguments, needs %s(...)", name);
      }
      e->operations += is_function(name);
    } else {
      if (!character_is_known(text, c, error)) return false;
      e->operations += strchr("+-*/^<>=!?&|", *c++) != NULL;
    }
  }
  return true;
}

/* What muParser's error codes mean; those not named here cannot arise from our names. */
static const char *grammar_text(int code) {
  static const char *const texts[] = {
      [0] = "unexpected operator",      [1] = "not understood",
      [2] = "unexpected end",           [3] = "unexpected comma",
      [4] = "unexpected argument",      [5] = "unexpected number",
      [6] = "unexpected variable",      [7] = "unexpected parenthesis",
      [10] = "a value is expected",     [11] = "missing parenthesis",
      [12] = "unexpected function",     [14] = "too many arguments",
      [15] = "too few arguments",       [25] = "the expression is empty",
      [33] = "\"?\" without its \":\"", [34] = "\":\" without its \"?\"",
  };
  const char *text = code >= 0 && code < (int)(sizeof texts / sizeof *texts) ? texts[code] : NULL;
  return text ? text : "not understood";
}

static bool grammar_failure(language *l, size_t length, expression_error *error) {
  int code = mupGetErrorCode(l->parser), position = mupGetErrorPos(l->parser);
  mupErrorReset(l->parser);
  bool is_within = position >= 0 && (size_t)position < length;
  return fail(error, is_within ? position + 1 : (int64_t)length, "%s", grammar_text(code));
}

bool expression_check(language *l, const char *text, int dim, expression *e,
                      expression_error *error) {
  *e = (expression){.text = text};
  if (!*text) return fail(error, 1, "the expression is empty");
  if (!words_are_known(l, text, dim, e, error)) return false;
  int values = 1;
  l->loaded = NULL;
  mupSetExpr(l->parser, text);
  if (!mupError(l->parser)) mupEvalMulti(l->parser, &values);
  if (mupError(l->parser)) return grammar_failure(l, strlen(text), error);
  if (values != 1) return fail(error, (int64_t)strlen(text), "%d values, needs one", values);
  l->loaded = text;
  return true;
}

/* Evaluation */

static void load_point(language *l, int64_t at, int dim, const double *point) {
  for (int k = 0; k < dim; k++) l->column[k][at] = point[k];
}

static bool evaluate_few(language *l, int dim, const double *x, const int32_t *place, int64_t m,
                         double time, double *out, int stride) {
  l->column[TIME][0] = time;
  for (int64_t k = 0; k < m; k++) {
    load_point(l, 0, dim, x + (place ? place[k] : k) * dim);
    out[k * stride] = mupEval(l->parser);
  }
  return !mupError(l->parser);
}

static bool evaluate_block(language *l, int dim, const double *x, const int32_t *place, int64_t m,
                           double time, double *out, int stride) {
  for (int64_t k = 0; k < m; k++) {
    load_point(l, k, dim, x + (place ? place[k] : k) * dim);
    l->column[TIME][k] = time;
  }
  mupEvalBulk(l->parser, l->result, (int)m);
  for (int64_t k = 0; k < m; k++) out[k * stride] = l->result[k];
  return !mupError(l->parser);
}

bool expression_evaluate(language *l, const expression *e, int dim, const double *x,
                         const int32_t *place, int64_t m, double time, double *out, int stride) {
  if (l->loaded != e->text) mupSetExpr(l->parser, e->text);
  l->loaded = e->text;
  bool done = true;
  if (m <= FEW) {
    done = evaluate_few(l, dim, x, place, m, time, out, stride);
  } else {
    for (int64_t k = 0; k < m && done; k += BLOCK) {
      int64_t size = m - k < BLOCK ? m - k : BLOCK;
      const double *from = place ? x : x + k * dim;
      done = evaluate_block(l, dim, from, place ? place + k : NULL, size, time, out + k * stride,
                            stride);
    }
  }
  mupErrorReset(l->parser);
  return done;
}
