/* param.h: the table of parameters, from defaults, texts, a file and the command line. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "param.h"

static void test_defaults(void **state) {
  (void)state;
  parameters p;
  param_defaults(&p);
  assert_string_equal(p.listen, "127.0.0.1:8480");
  assert_int_equal(p.limits.body_bytes, 256 << 20);
  assert_int_equal(p.limits.depth, 64);
  assert_int_equal(p.limits.points, 2000000);
  assert_int_equal(p.limits.neighbours, 500);
  assert_int_equal(p.limits.expression_bytes, 4096);
  assert_int_equal(p.limits.expression_work, 1000000000);
  assert_int_equal(p.limits.steps, 1000000);
  assert_true(p.limits.seconds > 0 && p.limits.threads > 0 && p.limits.memory_bytes > 0);
  assert_true(p.limits.decoded_bytes > 0 && p.limits.nodes > 0);
}

/* What a configuration file could hold reads back as itself. */
static void test_shown_values_read_back(void **state) {
  (void)state;
  parameters p, q;
  fault why;
  char room[PARAM_TEXT], again[PARAM_TEXT];
  int rows = 0;
  param_defaults(&p);
  memset(&q, 0xFF, sizeof q);
  for (; param_name(rows) != NULL; rows++) {
    param_show(&p, rows, room, sizeof room);
    assert_true(param_set(&q, param_name(rows), room, &why));
    assert_string_equal(param_show(&q, rows, again, sizeof again), room);
  }
  assert_true(rows > 25);
}

static void test_good_values(void **state) {
  (void)state;
  parameters p;
  fault why;
  static const struct {
    const char *name, *text;
    int64_t value;
  } rows[] = {{"body-bytes", "1024", 1024},       {"body-bytes", "3KiB", 3072},
              {"body-bytes", "1.5 MiB", 1572864}, {"memory-bytes", "2GiB", (int64_t)2 << 30},
              {"points", "1e6", 1000000},         {"points", "2M", 2000000},
              {"points", "10k", 10000},           {"queue", "0", 0},
              {"workers", "1024", 1024}};
  param_defaults(&p);
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    assert_true(param_set(&p, rows[k].name, rows[k].text, &why));
    char room[64];
    int row = 0;
    while (strcmp(param_name(row), rows[k].name) != 0) row++;
    assert_int_equal(atoll(param_show(&p, row, room, sizeof room)), rows[k].value);
  }
  assert_true(param_set(&p, "seconds", "0.25", &why));
  assert_true(p.limits.seconds == 0.25);
}

/* The message says name, got and needed; the old value stays. */
static void test_bad_values(void **state) {
  (void)state;
  static const char *const rows[][4] = {
      {"workers", "x", "\"x\"", "0 to 1024"},
      {"workers", "", "\"\"", "integer"},
      {"workers", "1.5", "1.5", "integer"},
      {"workers", "nan", "nan", "integer"},
      {"workers", "0x10", "0x10", "integer"},
      {"workers", "1025", "1025", "0 to 1024"},
      {"workers", "-1", "-1", "0 to 1024"},
      {"body-bytes", "1M", "1M", "bytes"},
      {"body-bytes", "1KiBx", "1KiBx", "bytes"},
      {"body-bytes", "0", "\"0\"", "bytes"},
      {"points", "99999999999", "99999999999", "2147483647"},
      {"depth", "501", "501", "1 to 500"},
      {"seconds", "-1", "-1", "0.01"},
      {"seconds", "inf", "inf", "number"},
      {"listen", "", "empty", "listen"},
      {"log-level", "verbose", "verbose", "error, info or debug"},
      {"public-url", "solve.example", "solve.example", "http://"},
      {"public-url", "http://a\"b", "http://a", "https://"},
      {"public-url", "http://a b", "http://a b", "https://"},
      {"no-such", "1", "no-such", "no parameter"},
  };
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    parameters p, before;
    fault why;
    param_defaults(&p);
    before = p;
    assert_false(param_set(&p, rows[k][0], rows[k][1], &why));
    assert_non_null(strstr(why.text, rows[k][0]));
    assert_non_null(strstr(why.text, rows[k][2]));
    assert_non_null(strstr(why.text, rows[k][3]));
    assert_memory_equal(&p, &before, sizeof p);
  }
}

static void test_text_that_is_too_long(void **state) {
  (void)state;
  parameters p;
  fault why;
  char text[PARAM_TEXT + 1];
  param_defaults(&p);
  memset(text, 'a', PARAM_TEXT);
  text[PARAM_TEXT] = '\0';
  assert_false(param_set(&p, "data-dir", text, &why));
  assert_non_null(strstr(why.text, "1023"));
  text[PARAM_TEXT - 1] = '\0';
  assert_true(param_set(&p, "data-dir", text, &why));
  assert_string_equal(p.data_dir, text);
}

static const char *write_file(const char *text) {
  static char path[32];
  strcpy(path, "/tmp/test-param-XXXXXX");
  const int fd = mkstemp(path);
  assert_true(fd >= 0);
  assert_int_equal(write(fd, text, strlen(text)), (ssize_t)strlen(text));
  close(fd);
  return path;
}

static void test_file(void **state) {
  (void)state;
  parameters p;
  fault why;
  const char *path = write_file(
      "# comment\n\n\tworkers =  7 # why\ndata-dir=/a#b\npublic-url = http://a/#x\nqueue=3");
  param_defaults(&p);
  assert_true(param_read(&p, path, &why));
  assert_int_equal(p.workers, 7);
  assert_int_equal(p.queue, 3);
  assert_string_equal(p.data_dir, "/a#b");
  assert_string_equal(p.public_url, "http://a/#x");
  unlink(path);
}

static void test_bad_file(void **state) {
  (void)state;
  parameters p;
  fault why;
  const char *path = write_file("workers = 1\n\nworkers 2\n");
  param_defaults(&p);
  assert_false(param_read(&p, path, &why));
  assert_non_null(strstr(why.text, ":3:"));
  unlink(path);
  assert_false(param_read(&p, path, &why));
  assert_non_null(strstr(why.text, path));
}

static void test_command_line(void **state) {
  (void)state;
  parameters p;
  fault why;
  const char *path = write_file("workers = 7\nqueue = 9\n");
  char *words[] = {"a",       "--workers=3", "--config", (char *)path, "--listen",
                   "unix:/x", "b",           "--",       "--queue"};
  int count = 9;
  param_defaults(&p);
  assert_true(param_take(&p, &count, words, &why));
  assert_int_equal(p.workers, 3); /* the command line wins, wherever the file stands */
  assert_int_equal(p.queue, 9);
  assert_string_equal(p.listen, "unix:/x");
  assert_int_equal(count, 3);
  assert_string_equal(words[0], "a");
  assert_string_equal(words[1], "b");
  assert_string_equal(words[2], "--queue");
  unlink(path);
}

static void test_bad_command_line(void **state) {
  (void)state;
  static const char *const rows[][2] = {{"--workers", "no value"},
                                        {"--nothing=1", "nothing"},
                                        {"--=1", "no parameter"},
                                        {"--config=/nowhere/x", "/nowhere/x"}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    parameters p;
    fault why;
    char *words[] = {(char *)rows[k][0]};
    int count = 1;
    param_defaults(&p);
    assert_false(param_take(&p, &count, words, &why));
    assert_non_null(strstr(why.text, rows[k][1]));
  }
}

/* Help and reference name every parameter. */
static void test_pages(void **state) {
  (void)state;
  void (*const pages[])(FILE *) = {param_help, param_reference, param_manual};
  for (size_t k = 0; k < sizeof pages / sizeof *pages; k++) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    pages[k](out);
    fclose(out);
    for (int row = 0; param_name(row) != NULL; row++) {
      assert_non_null(strstr(text, param_name(row)));
    }
    free(text);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_defaults),
      cmocka_unit_test(test_shown_values_read_back),
      cmocka_unit_test(test_good_values),
      cmocka_unit_test(test_bad_values),
      cmocka_unit_test(test_text_that_is_too_long),
      cmocka_unit_test(test_file),
      cmocka_unit_test(test_bad_file),
      cmocka_unit_test(test_command_line),
      cmocka_unit_test(test_bad_command_line),
      cmocka_unit_test(test_pages),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
