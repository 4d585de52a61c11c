/* model_error.h: errors in the form of UM-Bridge. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "model_error.h"

static void test_bytes(void **state) {
  size_t size = 0;
  char *bytes = model_error_bytes("InvalidInput", "got \"x\"\n", &size);
  (void)state;
  assert_non_null(bytes);
  assert_int_equal(strlen(bytes), size);
  assert_string_equal(bytes,
                      "{\"error\":{\"type\":\"InvalidInput\",\"message\":\"got \\\"x\\\"\\n\"}}");
  free(bytes);
}

static void test_types(void **state) {
  (void)state;
  assert_string_equal(model_error_type(401), "Unauthorized");
  assert_string_equal(model_error_type(429), "TooManyRequests");
  assert_string_equal(model_error_type(503), "ServiceUnavailable");
  /* all others are of the protocol */
  assert_string_equal(model_error_type(400), "InvalidInput");
  assert_string_equal(model_error_type(413), "InvalidInput");
  assert_string_equal(model_error_type(500), "InvalidOutput");
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_bytes), cmocka_unit_test(test_types)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
