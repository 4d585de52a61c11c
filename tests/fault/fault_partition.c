/* Parts of a cloud and their rows with the n-th allocation failing, for every n: SCT_E_MEMORY, no
 * output, no leak, and what failed works when it is called again; and the solve by ranks (here
 * one), for the first hundred n and some others. */
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../seed.h"
#include "../verify/manufactured.h"
#include "fail_each.h"
#include "scarce.h"

enum { CELLS = 8, PARTS = 3 };

static fixture all;
static manufactured data;
static sct_operator op;
static sct_fields fields;
static sct_boundary boundary;
static sct_ranks *ranks;

static sct_status cut(sct_partition **partition, sct_error *err) {
  const sct_status status = sct_partition_build(&all.cloud, PARTS, false, partition, err);
  assert_true((*partition != NULL) == (status == SCT_OK));
  return status;
}

static sct_status build(sct_error *err) {
  sct_partition *partition = (sct_partition *)&all;
  const sct_status status = cut(&partition, err);
  if (status == SCT_OK) {
    const int64_t first = sct_partition_start(partition, 1);
    assert_in_range(sct_partition_point(partition, first), 0, all.cloud.n - 1);
  }
  sct_partition_free(&partition);
  return status;
}

static sct_status part(sct_error *err) {
  sct_partition *partition;
  sct_part *p = (sct_part *)&all;
  sct_status status = cut(&partition, err);
  if (status != SCT_OK) return status;
  status = sct_part_build(&all.cloud, partition, 1, 3 * all.spacing, NULL, NULL, &p, err);
  assert_true((p != NULL) == (status == SCT_OK));
  sct_part_free(&p);
  sct_partition_free(&partition);
  return status;
}

static sct_part_problem problem(const sct_partition *partition) {
  return (sct_part_problem){&all.cloud,         partition, all.spacing, &op,
                            FIXTURE_NEIGHBOURS, &fields,   &boundary};
}

static sct_status rows(sct_error *err) {
  sct_partition *partition;
  sct_part_system *s = (sct_part_system *)&all;
  sct_status status = cut(&partition, err);
  if (status != SCT_OK) return status;
  const sct_part_problem p = problem(partition);
  status = sct_part_assemble(&p, 2, NULL, &s, err);
  assert_true((s != NULL) == (status == SCT_OK));
  sct_part_system_free(&s);
  sct_partition_free(&partition);
  return status;
}

/* Noting how far rows look takes nothing. */
static sct_status note(sct_error *err) {
  double reach[(CELLS + 1) * (CELLS + 1)] = {0};
  sct_room *room = NULL;
  sct_row r;
  const sct_row_request request = {.want = SCT_ROW_GRADIENT};
  sct_stencil_note_reach(all.stencil, reach);
  sct_status status = sct_room_new(all.stencil, &room, err);
  if (status == SCT_OK) status = sct_stencil_row(all.stencil, 40, &request, room, &r, err);
  assert_true((reach[40] > 0) == (status == SCT_OK));
  sct_stencil_note_reach(all.stencil, NULL);
  sct_room_free(&room);
  return status;
}

static sct_status solve(sct_error *err) {
  sct_partition *partition;
  sct_solve_report report;
  sct_ranks_report told;
  double phi[(CELLS + 1) * (CELLS + 1)];
  const sct_solve_options options = {.dim = 2, .preconditioner = "ilu"};
  sct_status status =
      sct_partition_build(&all.cloud, sct_ranks_count(ranks), false, &partition, err);
  if (status != SCT_OK) return status;
  const sct_part_problem p = problem(partition);
  memcpy(phi, data.value, sizeof phi);
  status = sct_ranks_solve(ranks, &p, &options, NULL, phi, &report, &told, err);
  sct_partition_free(&partition);
  return status;
}

/* In a process of its own, since one that has met SCT_E_MEMORY has to end: true if an allocation
 * failed, which a solve may get over. */
static bool runs_short(int64_t granted) {
  int how = 0;
  const pid_t child = fork();
  if (child == 0) {
    scarce_after(granted, true);
    const sct_status status = solve(NULL);
    const bool failed = scarce_end();
    if (status != SCT_OK && !(failed && status == SCT_E_MEMORY)) _exit(99);
    _exit(failed);
  }
  assert_true(child > 0 && waitpid(child, &how, 0) == child);
  assert_true(WIFEXITED(how) && WEXITSTATUS(how) != 99);
  return WEXITSTATUS(how) != 0;
}

static void parts_fail(void **state) {
  (void)state;
  fail_each(build, 2);
  fail_each(part, 5);
  fail_each(rows, 20);
  fail_each(note, 1);
}

static void ranks_fail(void **state) {
  (void)state;
  int rank = -1, count = -1;
  uint64_t seed = seed_new("fault.partition");
  assert_false(sct_ranks_place(&rank, &count));
  assert_int_equal(rank, 0);
  assert_int_equal(count, 1);
  sct_ranks_alone(); /* nobody is there: nothing to leave */
  /* what the libraries of MPI find when they start holds for the process: no second try */
  if (sct_ranks_open(&ranks, NULL) != SCT_OK) skip(); /* no PETSc */
  assert_int_equal(sct_ranks_rank(ranks), 0);
  int64_t granted = 0;
  while (runs_short(granted)) granted += granted < 100 ? 1 : 1 + (int64_t)seed_below(&seed, 20);
  assert_true(granted > 100);
  sct_ranks_close(&ranks);
  assert_null(ranks);
}

int main(void) {
  op = sct_operator_default(SCT_PS, 2);
  all = fixture_unit(2, CELLS, 0.4, 31, &op);
  data = manufactured_new(&all, 0);
  fields = manufactured_fields(&data);
  boundary = manufactured_boundary(&data);
  const struct CMUnitTest tests[] = {cmocka_unit_test(parts_fail), cmocka_unit_test(ranks_fail)};
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  manufactured_free(&data);
  fixture_clear(&all);
  return failed;
}
