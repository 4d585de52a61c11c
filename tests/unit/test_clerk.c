/* clerk.h: tasks in a thread of their own, in order, done in the loop; taken back; finished; files
 * closed and removed. */
#include <fcntl.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "clerk.h"

enum { LARGE = 100, COUNT = 200 };

typedef struct {
  loop *loop;
  clerk *clerk;
  pthread_t here;
  int done;             /* tasks so far */
  int wanted;           /* at which the loop stops */
  pthread_mutex_t door; /* the test's: a task waits at it */
} office;

typedef struct {
  clerk_task task;
  office *office;
  bool waits; /* at the door */
  bool was_here;
  int worked, told; /* how often; in which place */
} errand;

static void work(void *self) {
  errand *e = self;
  if (e->waits) {
    pthread_mutex_lock(&e->office->door);
    pthread_mutex_unlock(&e->office->door);
  }
  e->was_here = pthread_equal(pthread_self(), e->office->here);
  e->worked++;
}

static void done(void *self) {
  errand *e = self;
  office *o = e->office;
  assert_true(pthread_equal(pthread_self(), o->here));
  assert_int_equal(e->worked, 1);
  e->told = ++o->done;
  if (o->done == o->wanted) loop_stop(o->loop);
}

static errand errand_for(office *o, errand *self) {
  return (errand){.task = {work, done, self, NULL}, .office = o};
}

static int open_office(void **state) {
  static office o;
  fault why;
  o = (office){.loop = loop_new(), .here = pthread_self()};
  pthread_mutex_init(&o.door, NULL);
  o.clerk = clerk_new(o.loop, LARGE, &why);
  *state = &o;
  return o.clerk == NULL;
}

static int close_office(void **state) {
  office *o = *state;
  clerk_finish(o->clerk);
  clerk_free(&o->clerk);
  loop_free(&o->loop);
  pthread_mutex_destroy(&o->door);
  return 0;
}

static void test_small_at_once(void **state) {
  office *o = *state;
  errand e = errand_for(o, &e);
  clerk_do(o->clerk, &e.task, LARGE - 1);
  assert_true(e.was_here);
  assert_int_equal(e.told, 1);
}

static void test_large_in_order(void **state) {
  office *o = *state;
  errand all[COUNT];
  o->wanted = COUNT;
  pthread_mutex_lock(&o->door);
  for (int k = 0; k < COUNT; k++) {
    all[k] = errand_for(o, &all[k]);
    all[k].waits = k == 0;
    clerk_do(o->clerk, &all[k].task, LARGE);
  }
  assert_int_equal(o->done, 0);
  pthread_mutex_unlock(&o->door);
  loop_run(o->loop);
  for (int k = 0; k < COUNT; k++) {
    assert_false(all[k].was_here);
    assert_int_equal(all[k].told, k + 1);
  }
}

static void test_taken_back(void **state) {
  office *o = *state;
  errand all[4];
  o->wanted = 2;
  pthread_mutex_lock(&o->door);
  for (int k = 0; k < 4; k++) {
    all[k] = errand_for(o, &all[k]);
    all[k].waits = k == 0;
    clerk_do(o->clerk, &all[k].task, LARGE);
  }
  assert_true(clerk_take_back(o->clerk, &all[3].task)); /* the last */
  assert_true(clerk_take_back(o->clerk, &all[1].task));
  assert_false(clerk_take_back(o->clerk, &all[1].task));
  pthread_mutex_unlock(&o->door);
  loop_run(o->loop);
  assert_false(clerk_take_back(o->clerk, &all[0].task));
  const int worked[] = {1, 0, 1, 0};
  for (int k = 0; k < 4; k++) assert_int_equal(all[k].worked, worked[k]);
}

typedef struct {
  errand first, second;
} chain;

static void done_then_more(void *self) {
  chain *c = self;
  done(&c->first);
  clerk_do(c->first.office->clerk, &c->second.task, LARGE);
}

static void work_first(void *self) {
  work(&((chain *)self)->first);
}

/* What brings another task, too; and what comes later is done at once. */
static void test_finish(void **state) {
  office *o = *state;
  chain c = {.first = errand_for(o, &c.first), .second = errand_for(o, &c.second)};
  errand late = errand_for(o, &late);
  c.first.task = (clerk_task){work_first, done_then_more, &c, NULL};
  clerk_do(o->clerk, &c.first.task, LARGE);
  clerk_finish(o->clerk);
  assert_int_equal(c.second.told, 2);
  clerk_do(o->clerk, &late.task, LARGE);
  assert_int_equal(late.told, 3);
  assert_true(late.was_here);
}

typedef struct {
  clerk_task task;
  pthread_barrier_t *begun;
  atomic_bool works;
  bool alone;
} long_work;

static void work_long(void *self) {
  long_work *w = self;
  w->works = true;
  pthread_barrier_wait(w->begun);
  usleep(100000);
  w->works = false;
}

static void told_of_long(void *self) {
  (void)self;
}

static void work_beside(void *self) {
  long_work *w = self;
  w->alone = !w->works;
}

/* What a finished task brings is not done here while the thread is still at the next one. */
static void test_finish_one_at_a_time(void **state) {
  office *o = *state;
  pthread_barrier_t begun;
  long_work w = {.task = {work_long, told_of_long, &w, NULL}, .begun = &begun};
  chain c = {.first = errand_for(o, &c.first)};
  pthread_barrier_init(&begun, NULL, 2);
  c.first.task = (clerk_task){work_first, done_then_more, &c, NULL};
  c.second = (errand){.task = {work_beside, told_of_long, &w, NULL}};
  clerk_do(o->clerk, &c.first.task, LARGE);
  clerk_do(o->clerk, &w.task, LARGE);
  pthread_barrier_wait(&begun);
  clerk_finish(o->clerk);
  assert_true(w.alone);
  pthread_barrier_destroy(&begun);
}

static void test_files(void **state) {
  office *o = *state;
  char folder[] = "/tmp/clerk-test-XXXXXX";
  assert_non_null(mkdtemp(folder));
  const int at = open(folder, O_RDONLY | O_DIRECTORY);
  for (int size = 0; size <= LARGE; size += LARGE) { /* either way */
    const int fd = openat(at, "file", O_RDWR | O_CREAT, 0600);
    assert_int_equal(ftruncate(fd, size), 0);
    clerk_drop(o->clerk, at, "file");
    assert_int_equal(faccessat(at, "file", F_OK, 0), -1);
    const int copy = dup(fd);
    clerk_close(o->clerk, copy);
    if (size == LARGE) clerk_finish(o->clerk);
    assert_int_equal(fcntl(copy, F_GETFD), -1);
    close(fd);
  }
  clerk_drop(o->clerk, at, "nothing");
  clerk_close(o->clerk, -1);
  close(at);
  assert_int_equal(rmdir(folder), 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_small_at_once, open_office, close_office),
      cmocka_unit_test_setup_teardown(test_large_in_order, open_office, close_office),
      cmocka_unit_test_setup_teardown(test_taken_back, open_office, close_office),
      cmocka_unit_test_setup_teardown(test_finish, open_office, close_office),
      cmocka_unit_test_setup_teardown(test_finish_one_at_a_time, open_office, close_office),
      cmocka_unit_test_setup_teardown(test_files, open_office, close_office),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
