/* Linked to every cmocka test: SCATTERD_CASE=PATTERN in the environment runs only the cases whose
 * names match (* and ?). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

__attribute__((constructor)) static void choose_cases(void) {
  const char *pattern = getenv("SCATTERD_CASE");
  if (pattern != NULL) cmocka_set_test_filter(pattern);
}
