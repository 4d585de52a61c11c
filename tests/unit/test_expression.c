/* Expressions: what they mean, where they are wrong, and that one, few and many points agree. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "expression.h"

static const double X[3] = {0.75, -1.5, 2.25}, T = 0.125;

/* A task whose parameters are a and x_2. */
typedef struct {
  task t;
  doc parameters, a, b;
} fixture;

static int set_up(void **state) {
  fixture *f = calloc(1, sizeof *f);
  f->b = (doc){.kind = DOC_NUMBER, .key = "x_2", .number = 5};
  f->a = (doc){.kind = DOC_NUMBER, .key = "a", .number = 1e-3, .next = &f->b};
  f->parameters = (doc){.kind = DOC_OBJECT, .child = &f->a, .count = 2};
  f->t.parameters = &f->parameters;
  f->t.work.threads = 1;
  *state = f;
  return 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  language_free(&f->t.language);
  free(f);
  return 0;
}

static double value_of(fixture *f, const char *text) {
  expression e;
  expression_error why = {0};
  double out = NAN;
  language *l = language_of(&f->t);
  if (!expression_check(l, text, 3, &e, &why)) {
    fail_msg("%s: %s at %lld", text, why.text, (long long)why.position);
  }
  assert_true(expression_evaluate(l, &e, 3, X, NULL, 1, T, &out, 1));
  return out;
}

static void test_values(void **state) {
  const double x = X[0], y = X[1], z = X[2], t = T, a = 1e-3, pi = acos(-1);
  const struct {
    const char *text;
    double value;
  } cases[] = {
      {"1", 1},
      {".5", 0.5},
      {"5.", 5},
      {"1e-3", 1e-3},
      {"2.5E+2", 250},
      {"x", x},
      {"y", y},
      {"z", z},
      {"t", t},
      {"pi", pi},
      {"a", a},
      {"x_2*a", 5 * a},
      {"x + y*z - t/a", x + y * z - t / a},
      {"-x^2", -x * x},
      {"2^3^2", 512},
      {"2^-1", 0.5},
      {"(x+y)*(x-y)", (x + y) * (x - y)},
      {"10-4-3", 3},
      {"16/4/2", 2},
      {"x < 1", 1},
      {"x <= 0.75", 1},
      {"x > 1", 0},
      {"x >= 1", 0},
      {"x == 0.75", 1},
      {"x != 0.75", 0},
      {"x < 1 && y > 0", 0},
      {"x < 1 || y > 0", 1},
      {"x > 1 ? 2 : y > 0 ? 3 : 4", 4},
      {"sin(x)", sin(x)},
      {"cos(x)", cos(x)},
      {"tan(x)", tan(x)},
      {"asin(x)", asin(x)},
      {"acos(x)", acos(x)},
      {"atan(x)", atan(x)},
      {"atan2(y, x)", atan2(y, x)},
      {"sinh(x)", sinh(x)},
      {"cosh(x)", cosh(x)},
      {"tanh(x)", tanh(x)},
      {"asinh(x)", asinh(x)},
      {"acosh(z)", acosh(z)},
      {"atanh(x)", atanh(x)},
      {"exp(x)", exp(x)},
      {"exp2(x)", exp2(x)},
      {"expm1(x)", expm1(x)},
      {"log(x)", log(x)},
      {"ln(x)", log(x)},
      {"log10(x)", log10(x)},
      {"log2(x)", log2(x)},
      {"log1p(x)", log1p(x)},
      {"sqrt(x)", sqrt(x)},
      {"cbrt(y)", cbrt(y)},
      {"hypot(x, y)", hypot(x, y)},
      {"pow(z, 3)", pow(z, 3)},
      {"fmod(z, x)", fmod(z, x)},
      {"fabs(y) + fmin(x, y) - fmax(x, y)", fabs(y) + fmin(x, y) - fmax(x, y)},
      {"tgamma(x) + fdim(x, y) + rint(z) + copysign(x, y)",
       tgamma(x) + fdim(x, y) + rint(z) + copysign(x, y)},
      {"abs(y)", fabs(y)},
      {"floor(y)", -2},
      {"ceil(y)", -1},
      {"round(z)", 2},
      {"trunc(y)", -1},
      {"erf(x)", erf(x)},
      {"erfc(x)", erfc(x)},
      {"gamma(z)", tgamma(z)},
      {"lgamma(z)", lgamma(z)},
      {"sign(y)", -1},
      {"sign(x-x)", 0},
      {"step(y)", 0},
      {"step(x-x)", 1},
      {"min(3, y, x)", y},
      {"max(3, y, x)", 3},
      {"1 + tanh(10*(2*x+1))", 1 + tanh(10 * (2 * x + 1))},
      {"exp(-2*(2*pi)^2*t)*sin(2*pi*x)", exp(-2 * pow(2 * pi, 2) * t) * sin(2 * pi * x)},
      {" x\t+\n y ", x + y},
  };
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    double value = value_of(*state, cases[k].text);
    if (fabs(value - cases[k].value) <= 4e-16 * fabs(cases[k].value)) continue;
    fail_msg("%s is %.17g, needs %.17g", cases[k].text, value, cases[k].value);
  }
}

static void test_errors(void **state) {
  fixture *f = *state;
  static const struct {
    const char *text;
    int64_t position;
    const char *says;
  } cases[] = {
      {"", 1, "empty"},
      {"   ", 3, "empty"},
      {"q + 1", 1, "\"q\""},
      {"1 + sine(x)", 5, "\"sin\""},
      {"x + z", 5, "2-D"},
      {"e", 1, "unknown name"},
      {"_pi", 1, "pi"},
      {"x_3", 1, "\"x_2\""},
      {"x = 1", 3, "=="},
      {"x**2", 2, "powers need ^"},
      {"x + \"y\"", 5, "\"\"\""},
      {"x # y", 3, "#"},
      {"x \xc3\xa4", 3, "character"},
      {"sin(x", 5, "missing parenthesis"},
      {"sin(x, y)", 9, "too many"},
      {"hypot(x)", 8, "too few"},
      {"x y", 3, "variable"},
      {"2 3", 3, "number"},
      {"(x", 2, ""},
      {"x)", 2, "parenthesis"},
      {"x *", 3, "end"},
      {"* x", 1, "operator"},
      {"x ? 1", 5, ":"},
      {"1, 2", 4, "2 values"},
      {"0x10", 2, "unknown name"},
      {"sin", 1, "sin(...)"},
      {"x;y", 2, ";"},
      {"min()", 5, ""},
      {"1e", 2, "unknown name"},
      {"1..2", 0, ""},
      {"x && & y", 0, ""},
  };
  int failed = 0;
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    expression e;
    expression_error why = {0};
    if (expression_check(language_of(&f->t), cases[k].text, 2, &e, &why)) {
      failed++;
      print_error("\"%s\" passes\n", cases[k].text);
    }
    bool is_there = !cases[k].position || why.position == cases[k].position;
    if (is_there && strstr(why.text, cases[k].says)) continue;
    failed++;
    print_error("\"%s\": got \"%s\" at %lld, needs %s at %lld\n", cases[k].text, why.text,
                (long long)why.position, cases[k].says, (long long)cases[k].position);
  }
  assert_int_equal(0, failed);
  assert_true(value_of(f, "x") == X[0]); /* an error leaves nothing behind */
}

static void test_varies(void **state) {
  fixture *f = *state;
  expression e;
  expression_error why;
  assert_true(expression_check(language_of(&f->t), "x*tan(y)", 2, &e, &why));
  assert_false(e.varies);
  assert_true(expression_check(language_of(&f->t), "x*tan(t)", 2, &e, &why));
  assert_true(e.varies);
}

static void test_names(void **state) {
  (void)state;
  assert_true(expression_is_name("mu"));
  assert_true(expression_is_name("Re_2"));
  assert_false(expression_is_name(""));
  assert_false(expression_is_name("_a"));
  char name[EXPRESSION_NAME + 1];
  memset(name, 'a', sizeof name);
  name[EXPRESSION_NAME] = '\0';
  assert_false(expression_is_name(name));
  name[EXPRESSION_NAME - 1] = '\0';
  assert_true(expression_is_name(name));
  assert_false(expression_is_name("2a"));
  assert_false(expression_is_name("a b"));
  assert_true(expression_is_reserved("x"));
  assert_true(expression_is_reserved("t"));
  assert_true(expression_is_reserved("pi"));
  assert_true(expression_is_reserved("max"));
  assert_false(expression_is_reserved("e"));
}

/* One by one, in one block and in several, with and without places, strided or not. */
static void test_many(void **state) {
  enum { N = 20011 };
  fixture *f = *state;
  language *l = language_of(&f->t);
  static double x[2 * N], out[2 * N], back[N];
  static int32_t place[N];
  expression e;
  expression_error why;
  for (int k = 0; k < N; k++) {
    x[2 * k] = 1e-3 * k;
    x[2 * k + 1] = 1 - 1e-4 * k;
    place[k] = N - 1 - k;
  }
  assert_true(expression_check(l, "x*x - y + t*a", 2, &e, &why));
  assert_true(expression_evaluate(l, &e, 2, x, NULL, N, T, out, 2));
  assert_true(expression_evaluate(l, &e, 2, x, place, N, T, back, 1));
  for (int k = 0; k < N; k++) {
    double one, exact = x[2 * k] * x[2 * k] - x[2 * k + 1] + T * 1e-3;
    if (k % 97 == 0) {
      assert_true(expression_evaluate(l, &e, 2, x + 2 * k, NULL, 1, T, &one, 1));
      assert_true(one == out[2 * k]);
    }
    assert_true(fabs(out[2 * k] - exact) <= 1e-12);
    assert_true(back[N - 1 - k] == out[2 * k]);
  }
}

static void test_operations(void **state) {
  fixture *f = *state;
  static const struct {
    const char *text;
    int64_t operations;
  } cases[] = {{"x", 0},       {"1e-3", 0},       {"x + 2*y", 2},
               {"(((x)))", 0}, {"sin(x) ^ 2", 2}, {"min(x, y, 1)", 1},
               {"-x", 1},      {"x ? 1 : y", 1},  {"sinh(sin(x))", 2}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    expression e;
    expression_error why = {0};
    assert_true(expression_check(language_of(&f->t), cases[k].text, 3, &e, &why));
    assert_int_equal(e.operations, cases[k].operations);
  }
}

/* As deep as the longest text allows: understood, or refused. */
static void test_deep(void **state) {
  fixture *f = *state;
  static const char *const around[][2] = {
      {"(", ")"}, {"-", ""}, {"sin(", ")"}, {"x^", ""}, {"x?", ":x"}};
  char text[4097];
  for (size_t k = 0; k < sizeof around / sizeof *around; k++) {
    const size_t before = strlen(around[k][0]), after = strlen(around[k][1]);
    const size_t deep = (sizeof text - 2) / (before + after);
    char *at = text;
    for (size_t n = 0; n < deep; n++) at = mempcpy(at, around[k][0], before);
    *at++ = 'x';
    for (size_t n = 0; n < deep; n++) at = mempcpy(at, around[k][1], after);
    *at = '\0';
    expression e;
    expression_error why = {0};
    double out = 0;
    language *l = language_of(&f->t);
    if (expression_check(l, text, 3, &e, &why)) {
      assert_true(expression_evaluate(l, &e, 3, X, NULL, 1, T, &out, 1));
    } else {
      assert_true(*why.text != '\0');
    }
  }
  assert_true(value_of(f, "1 + 1") == 2); /* the parser is none the worse */
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_values, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_errors, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_varies, set_up, tear_down),
      cmocka_unit_test(test_names),
      cmocka_unit_test_setup_teardown(test_operations, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_deep, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_many, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
