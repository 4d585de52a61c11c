/* memory_file.h: what is sealed stays as it is; what is something else is never sealed. */
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmocka.h>

#include "memory_file.h"

static void test_sealed(void **state) {
  (void)state;
  char back[4] = "";
  const int fd = memory_file("test");
  assert_true(fd >= 0);
  assert_int_equal(write(fd, "abc", 3), 3);
  assert_false(memory_file_is_sealed(fd));
  assert_true(memory_file_seal(fd));
  assert_true(memory_file_is_sealed(fd));
  assert_int_equal(pwrite(fd, "x", 1, 0), -1);
  assert_int_equal(ftruncate(fd, 1), -1);
  assert_int_equal(ftruncate(fd, 9), -1);
  assert_ptr_equal(mmap(NULL, 3, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0), MAP_FAILED);
  assert_int_equal(pread(fd, back, sizeof back, 0), 3);
  assert_string_equal(back, "abc");
  close(fd);
}

static void test_not_while_somebody_may_write(void **state) {
  (void)state;
  const int fd = memory_file("test");
  assert_int_equal(ftruncate(fd, 3), 0);
  void *page = mmap(NULL, 3, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  assert_ptr_not_equal(page, MAP_FAILED);
  assert_false(memory_file_seal(fd));
  assert_int_equal(errno, EBUSY);
  munmap(page, 3);
  close(fd);
}

static void test_others(void **state) {
  (void)state;
  int ends[2];
  assert_int_equal(pipe(ends), 0);
  assert_false(memory_file_seal(ends[0]));
  assert_false(memory_file_is_sealed(ends[0]));
  close(ends[0]);
  close(ends[1]);
  assert_false(memory_file_is_sealed(-1));
  const int unsealable = memfd_create("test", MFD_CLOEXEC); /* it has a seal: against seals */
  assert_false(memory_file_is_sealed(unsealable));
  close(unsealable);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_sealed),
      cmocka_unit_test(test_not_while_somebody_may_write),
      cmocka_unit_test(test_others),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
