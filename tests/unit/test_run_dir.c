/* A run as files: what was put is there whole, news come in order and once, what another version
 * wrote is refused, and nothing of a directory is left. */
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "run_dir.h"

static char place[] = "/tmp/run-dir-test-XXXXXX";
static int top = -1, dir = -1;

static int set_up(void **state) {
  (void)state;
  if (mkdtemp(place) == NULL) return 1;
  top = run_dir_open(place);
  if (top < 0 || mkdirat(top, "run", 0700) != 0) return 1;
  dir = openat(top, "run", O_RDONLY | O_DIRECTORY);
  return dir < 0;
}

static int tear_down(void **state) {
  (void)state;
  close(dir);
  close(top);
  return rmdir(place);
}

static void asks_come_back(void **state) {
  (void)state;
  ipc_ask ask = {.work = IPC_RUN_STORED, .process = "solve", .size = 17}, back;
  ask.limits.ranks = 4;
  assert_false(run_dir_get_ask(dir, &back));
  assert_true(run_dir_put_ask(dir, &ask));
  assert_true(run_dir_get_ask(dir, &back));
  assert_memory_equal(&back, &ask, sizeof ask);
}

static void other_versions_are_refused(void **state) {
  (void)state;
  ipc_news reply = {.kind = IPC_REPLY, .status = 200};
  assert_true(run_dir_put_reply(dir, &reply));
  assert_true(run_dir_get_reply(dir, &reply));
  int64_t size;
  const int fd = run_dir_get(dir, "reply", &size);
  char *bytes = malloc((size_t)size + 1);
  assert_int_equal(read(fd, bytes, (size_t)size), size);
  close(fd);
  for (int shift = -1; shift <= 1; shift += 2) { /* shorter, longer */
    assert_true(run_dir_put(dir, "reply", bytes, (size_t)(size + shift)));
    assert_false(run_dir_get_reply(dir, &reply));
    assert_int_equal(errno, EPROTO);
  }
  bytes[0] ^= 1;
  assert_true(run_dir_put(dir, "reply", bytes, (size_t)size));
  assert_false(run_dir_get_reply(dir, &reply));
  free(bytes);
}

static void news_come_once_and_in_order(void **state) {
  (void)state;
  ipc_news news = {.kind = IPC_PROGRESS}, heard;
  int64_t at = 0;
  assert_false(run_dir_hear(dir, &at, &heard));
  for (int k = 0; k < 5; k++) {
    news.fraction = k / 5.0;
    assert_true(run_dir_tell(dir, &news));
    if (k % 2 == 0) continue;
    assert_true(run_dir_hear(dir, &at, &heard));
    assert_true(heard.fraction == (k - 1) / 5.0);
    assert_true(run_dir_hear(dir, &at, &heard));
    assert_true(heard.fraction == k / 5.0);
    assert_false(run_dir_hear(dir, &at, &heard));
  }
  /* half of one is none yet */
  const int fd = openat(dir, "news", O_WRONLY | O_APPEND);
  assert_true(run_dir_hear(dir, &at, &heard));
  assert_int_equal(write(fd, &news, sizeof news / 2), sizeof news / 2);
  assert_false(run_dir_hear(dir, &at, &heard));
  assert_int_equal(write(fd, (char *)&news + sizeof news / 2, sizeof news - sizeof news / 2),
                   sizeof news - sizeof news / 2);
  assert_true(run_dir_hear(dir, &at, &heard));
  close(fd);
}

static void files_are_copied_whole(void **state) {
  (void)state;
  static const char text[] = "points and values";
  char back[sizeof text] = "";
  int64_t size = 0;
  assert_true(run_dir_put(dir, "body", text, sizeof text));
  const int from = run_dir_get(dir, "body", &size);
  assert_int_equal(size, sizeof text);
  assert_true(run_dir_copy(dir, "state", from, sizeof text));
  assert_false(run_dir_copy(dir, "more", from, sizeof text + 1)); /* than there is */
  close(from);
  assert_int_equal(run_dir_get(dir, "more", &size), -1);
  const int fd = run_dir_get(dir, "state", &size);
  assert_int_equal(read(fd, back, sizeof back), sizeof text);
  assert_string_equal(back, text);
  close(fd);
}

static void nothing_is_left(void **state) {
  (void)state;
  assert_int_equal(mkdirat(dir, "taken", 0700), 0);
  run_dir_remove(top, "run");
  run_dir_remove(top, "never there");
  assert_int_equal(faccessat(top, "run", F_OK, 0), -1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(asks_come_back),
      cmocka_unit_test(other_versions_are_refused),
      cmocka_unit_test(news_come_once_and_in_order),
      cmocka_unit_test(files_are_copied_whole),
      cmocka_unit_test(nothing_is_left),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
