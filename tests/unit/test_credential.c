/* credential.h: the forms that let in, and many that do not. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <stdio.h>
#include <unistd.h>

#include "base64.h"
#include "credential.h"
#include "seed.h"

static char secret[TOKEN_SECRET];

static int set_up(void **state) {
  char line[TOKEN_LINE], path[] = "/tmp/test-credential-XXXXXX";
  fault why;
  bool is_public;
  const int fd = mkstemp(path);
  if (!token_make("alice", 0, NULL, secret, line, &why)) return 1;
  if (write(fd, line, strlen(line)) != (ssize_t)strlen(line)) return 1;
  close(fd);
  *state = tokens_read(path, NULL, &is_public, &why);
  unlink(path);
  return *state == NULL;
}

static int tear_down(void **state) {
  tokens *t = *state;
  tokens_free(&t);
  return 0;
}

/* "Basic " and the pair in base64; malloc'ed. */
static char *basic(const char *pair, size_t size) {
  size_t length;
  char *text = base64_encode(pair, size, &length), *field = NULL;
  assert_true(asprintf(&field, "Basic %s", text) > 0);
  free(text);
  return field;
}

static bool is_let_in(void **state, const char *field) {
  const token *found = credential_find(*state, field);
  if (found != NULL) assert_string_equal(found->name, "alice");
  return found != NULL;
}

static void test_forms(void **state) {
  char field[200], pair[200];
  static const char *const formats[] = {"Bearer %s", "bearer %s", "BEARER    %s"};
  for (size_t k = 0; k < sizeof formats / sizeof *formats; k++) {
    snprintf(field, sizeof field, formats[k], secret);
    assert_true(is_let_in(state, field));
  }
  snprintf(pair, sizeof pair, "alice:%s", secret);
  char *good = basic(pair, strlen(pair));
  assert_true(is_let_in(state, good));
  good[strcspn(good, "=")] = '\0'; /* without padding */
  assert_true(is_let_in(state, good));
  free(good);
}

static void test_others(void **state) {
  static const char *const formats[] = {"%s",         "Bearer%s", "Bearer %s ",   " Bearer %s",
                                        "Basic %s",   "Token %s", "Bearer %s, x", "Bearer \"%s\"",
                                        "Bearer\t%s", "Bear %s",  "Bearer x%s"};
  static const char *const pairs[] = {"bob:%s",   ":%s",       "%s",       "alice:%s ", "alice::%s",
                                      "Alice:%s", "alice:x%s", "%s:alice", "alice%s"};
  char text[200];
  for (size_t k = 0; k < sizeof formats / sizeof *formats; k++) {
    snprintf(text, sizeof text, formats[k], secret);
    assert_false(is_let_in(state, text));
  }
  for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) {
    snprintf(text, sizeof text, pairs[k], secret);
    char *field = basic(text, strlen(text));
    assert_false(is_let_in(state, field));
    free(field);
  }
  snprintf(text, sizeof text, "alice:%s", secret);
  char *field = basic(text, strlen(text) + 1); /* the NUL too */
  assert_false(is_let_in(state, field));
  free(field);
  static const char *const odd[] = {"",           " ",          "Bearer",    "Bearer ",
                                    "Basic",      "Basic ",     "Basic =",   "Basic ????",
                                    "Basic Og==", "Basic OmE=", "Basic AAAA"};
  for (size_t k = 0; k < sizeof odd / sizeof *odd; k++) assert_false(is_let_in(state, odd[k]));
}

/* No secret that differs in one place. */
static void test_near_misses(void **state) {
  uint64_t seed = seed_new("credential");
  char field[200];
  for (int k = 0; k < 2000; k++) {
    snprintf(field, sizeof field, "Bearer %s", secret);
    char *at = field + 7 + seed_below(&seed, TOKEN_SECRET - 1);
    const char before = *at;
    do *at = (char)(33 + seed_below(&seed, 94));
    while (*at == before);
    assert_false(is_let_in(state, field));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_forms), cmocka_unit_test(test_others),
                                     cmocka_unit_test(test_near_misses)};
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
