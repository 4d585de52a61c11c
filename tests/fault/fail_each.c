#include "fail_each.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "scarce.h"

void fail_each(attempt *run, int at_least) {
  for (int lasting = 0; lasting <= 1; lasting++) {
    int64_t granted = 0;
    for (bool failed = true; failed; granted++) {
      sct_error err = {.code = SCT_OK};
      scarce_after(granted, lasting);
      const sct_status status = run(&err);
      failed = scarce_end();
      assert_int_equal(status, failed ? SCT_E_MEMORY : SCT_OK);
      assert_int_equal(err.code, status);
    }
    assert_true(granted > at_least);
  }
}
