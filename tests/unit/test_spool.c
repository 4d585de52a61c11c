/* spool.h: bodies in memory and in files without a name. */
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "memory_file.h"
#include "spool.h"

static void check(int64_t memory, bool on_disk) {
  spool s = SPOOL_EMPTY;
  char bytes[1000], back[3000];
  for (int part = 0; part < 3; part++) {
    memset(bytes, 'a' + part, sizeof bytes);
    assert_true(spool_add(&s, bytes, sizeof bytes, memory, "/tmp"));
  }
  assert_int_equal(s.size, 3000);
  assert_int_equal(s.on_disk, on_disk);
  assert_int_equal(pread(s.fd, back, sizeof back, 0), 3000);
  for (int k = 0; k < 3000; k++) assert_int_equal(back[k], 'a' + k / 1000);
  struct stat facts;
  assert_int_equal(fstat(s.fd, &facts), 0);
  assert_int_equal(facts.st_nlink, 0);
  spool_close(&s);
  assert_int_equal(s.fd, -1);
  spool_close(&s);
}

static void test_places(void **state) {
  (void)state;
  check(1 << 20, false);
  check(3000, false);
  check(2999, true);
  check(1000, true);
  check(0, true);
}

static void test_no_directory(void **state) {
  (void)state;
  spool s = SPOOL_EMPTY;
  assert_true(spool_add(&s, "abc", 3, 5, "/does/not/exist"));
  assert_false(spool_add(&s, "abc", 3, 5, "/does/not/exist"));
  assert_int_equal(errno, ENOENT);
  assert_int_equal(s.size, 3);
  spool_close(&s);
}

/* Whoever gets the descriptor of a whole spool on disk can read it, and nothing else. */
static void test_end_on_disk(void **state) {
  (void)state;
  spool s = SPOOL_EMPTY;
  char back[3] = "";
  assert_true(spool_add(&s, "abc", 3, 0, "/tmp"));
  assert_true(spool_end(&s));
  assert_int_equal(s.size, 3);
  assert_int_equal(pwrite(s.fd, "x", 1, 0), -1);
  assert_int_equal(pwrite(s.fd, "x", 1, 3), -1);
  assert_int_equal(ftruncate(s.fd, 0), -1);
  assert_int_equal(ftruncate(s.fd, 1000), -1);
  assert_int_equal(pread(s.fd, back, 3, 0), 3);
  assert_memory_equal(back, "abc", 3);
  spool_close(&s);
}

static void test_end_of_others(void **state) {
  (void)state;
  spool s = SPOOL_EMPTY;
  assert_true(spool_end(&s));
  assert_int_equal(s.fd, -1);
  assert_true(spool_add(&s, "abc", 3, 100, "/tmp"));
  const int fd = s.fd;
  assert_true(spool_end(&s));
  assert_int_equal(s.fd, fd);
  assert_true(memory_file_seal(fd)); /* which whoever hands it on does */
  spool_close(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_places),
      cmocka_unit_test(test_no_directory),
      cmocka_unit_test(test_end_on_disk),
      cmocka_unit_test(test_end_of_others),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
