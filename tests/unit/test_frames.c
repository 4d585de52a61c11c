/* frames.h: what a check says, and nonsense. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#include "frames.h"
#include "seed.h"

static void put(int fd, ipc_frame_kind kind, const char *text, int64_t claimed) {
  ipc_frame frame = {.kind = kind, .size = claimed, .points = 5, .memory_bytes = 6};
  strcpy(frame.process, "solve");
  assert_int_equal(write(fd, &frame, sizeof frame), sizeof frame);
  assert_int_equal(write(fd, text, strlen(text)), strlen(text));
}

static bool read_all(int fd, frames *f, char uri[3][JOB_URI]) {
  return frames_read(fd, (size_t)lseek(fd, 0, SEEK_END), f, uri);
}

static void test_good(void **state) {
  static char uri[3][JOB_URI];
  const int fd = memfd_create("frames", 0);
  frames f;
  (void)state;
  assert_true(read_all(fd, &f, uri)); /* nothing to say */
  put(fd, IPC_FRAME_FAILED, "http://a/f", 10);
  put(fd, IPC_FRAME_HREF, "/data/x", 7);
  put(fd, IPC_FRAME_CHILD, "first", 5);
  put(fd, IPC_FRAME_CHILD, "second", 6);
  put(fd, IPC_FRAME_CHILD, "", 0);
  assert_true(read_all(fd, &f, uri));
  assert_string_equal(uri[2], "http://a/f");
  assert_string_equal(uri[0], "");
  assert_false(f.external);
  assert_int_equal(f.count, 3);
  char bytes[7] = "";
  assert_int_equal(pread(fd, bytes, (size_t)f.parts[1].size, f.parts[1].offset), 6);
  assert_string_equal(bytes, "second");
  assert_string_equal(f.parts[1].process, "solve");
  assert_int_equal(f.parts[1].points, 5);
  assert_int_equal(f.parts[1].estimate, 6);
  frames_free(&f);
  put(fd, IPC_FRAME_HREF, "HTTPS://b/", 10);
  assert_true(read_all(fd, &f, uri));
  assert_true(f.external);
  assert_int_equal(f.pins, 0);
  frames_free(&f);
  close(fd);
}

/* Objects under /data are pinned, whatever stands before; nothing else is. */
static void test_pins(void **state) {
#define ID "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"
  static const char *const hrefs[] = {"/data/" ID,        "http://a/b/data/" ID, "/data/" ID "/",
                                      "/data/" ID "0",    "/jobs/" ID,           "data/" ID,
                                      "/jobs/1/results/x"};
  static char uri[3][JOB_URI];
  const int fd = memfd_create("frames", 0);
  frames f;
  (void)state;
  for (size_t k = 0; k < sizeof hrefs / sizeof *hrefs; k++) {
    put(fd, IPC_FRAME_HREF, hrefs[k], (int64_t)strlen(hrefs[k]));
  }
  assert_true(read_all(fd, &f, uri));
  assert_int_equal(f.pins, 2);
  assert_string_equal(f.pin[0], ID);
  assert_string_equal(f.pin[1], ID);
  frames_free(&f);
  for (int k = 0; k < JOB_PINS; k++) put(fd, IPC_FRAME_HREF, hrefs[0], (int64_t)strlen(hrefs[0]));
  assert_false(read_all(fd, &f, uri)); /* more than a request may have */
  frames_free(&f);
  close(fd);
}

static void test_nonsense(void **state) {
  static char uri[3][JOB_URI];
  static const struct {
    ipc_frame_kind kind;
    int64_t claimed;
  } rows[] = {{(ipc_frame_kind)77, 3}, {IPC_FRAME_CHILD, 4},         {IPC_FRAME_CHILD, -1},
              {IPC_FRAME_CHILD, 2},    {IPC_FRAME_CHILD, INT64_MAX}, {IPC_FRAME_SUCCESS, JOB_URI}};
  (void)state;
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const int fd = memfd_create("frames", 0);
    frames f;
    put(fd, rows[k].kind, "abc", rows[k].claimed);
    assert_false(read_all(fd, &f, uri));
    frames_free(&f);
    close(fd);
  }
}

static void test_random(void **state) {
  static char uri[3][JOB_URI];
  uint64_t r = seed_new("random");
  (void)state;
  for (int round = 0; round < 2000; round++) {
    const int fd = memfd_create("frames", 0);
    frames f;
    put(fd, IPC_FRAME_SUCCESS, "http://a/", 9);
    put(fd, IPC_FRAME_CHILD, "abc", 3);
    for (int k = 0; k < 3; k++) {
      const unsigned char byte = (unsigned char)seed_below(&r, 256);
      const off_t at = seed_below(&r, 2 * (int)sizeof(ipc_frame) + 12);
      assert_int_equal(pwrite(fd, &byte, 1, at), 1);
    }
    (void)read_all(fd, &f, uri);
    frames_free(&f);
    close(fd);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_good), cmocka_unit_test(test_pins),
                                     cmocka_unit_test(test_nonsense),
                                     cmocka_unit_test(test_random)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
