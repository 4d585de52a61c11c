/* process_study.c - a published test problem on several meshes, beside the paper's own numbers.
 *
 * A case is data (study_case.h). Each of its rows is one or more ordinary requests of `solve` or
 * `apply`, handed out as output `requests`; what they find is put together here, and nothing else
 * is computed. */
#include "estimate.h"
#include "process.h"
#include "report.h"
#include "study_paper.h"

/* Bits of `wanted`: the outputs in their order. */
enum { TABLE = 1, REFERENCE = 2, REQUESTS = 4 };

typedef struct {
  study_input in;
  study_row *row; /* [in.rows] */
  bool *used;     /* [columns] of the case */
  int64_t memory; /* estimated, of the largest run (bytes) */
} study;

/* The request of every row is made and read, so that what is wrong is found before any runs. */
static void read_study(task *t, const item *in, void *state) {
  study *s = state;
  if (!study_input_read(t, in, &s->in)) return;
  for (int64_t k = 0; k < s->in.rows && !t->error.code && t->complaints.count < PROBLEM_ERRORS_MAX;
       k++) {
    study_run run;
    if (study_run_open(t, &s->in, k, 0, 1, &run)) {
      const int64_t memory = estimate_run(&run.own, &run.work);
      if (memory > s->memory) s->memory = memory;
    }
    study_run_close(&run);
  }
}

static int64_t memory_of_study(const task *t, const void *state) {
  (void)t;
  return ((const study *)state)->memory;
}

/* Keeps the request of a run for the output `requests`. */
static void keep_request(study_run *run, study_row *row) {
  row->request = run->request;
  row->request_arena = run->request_arena;
  run->request_arena = NULL;
}

static sct_status run_cloud(task *t, study *s, int64_t k, int64_t cloud, unsigned wanted) {
  const double done = (double)(k * s->in.seeds + cloud) / (double)(s->in.rows * s->in.seeds);
  const doc *result = NULL;
  double measured;
  study_run run;
  if (!study_run_measure(t, &s->in, k, cloud, done, &measured)) return t->error.code;
  bool good = study_run_open(t, &s->in, k, cloud, measured, &run);
  if (good) result = study_run_perform(t, &run, done);
  good = result && study_row_add(t, &run, result, &s->row[k]);
  if (good && cloud == 0 && (wanted & REQUESTS)) keep_request(&run, &s->row[k]);
  study_run_close(&run);
  return t->error.code;
}

static sct_status run_row(task *t, study *s, int64_t k, unsigned wanted) {
  const study_input *in = &s->in;
  study_row *row = &s->row[k];
  row->cells = (int64_t)in->cells.data[k % in->cells.rows];
  if (in->varied) row->varied = in->varied->key;
  if (in->varied) row->value = in->varied->data[k / in->cells.rows];
  for (int64_t cloud = 0; cloud < in->seeds; cloud++) {
    sct_status status = run_cloud(t, s, k, cloud, wanted);
    if (status || !task_is_well(t)) return status;
  }
  return study_paper_find(t, in, k, row, s->used) ? SCT_OK : t->error.code;
}

static sct_status run_study(task *t, unsigned wanted, void *state) {
  study *s = state;
  s->row = task_zeros(t, s->in.rows, sizeof *s->row);
  s->used = task_zeros(t, study_paper_columns(&s->in), sizeof *s->used);
  if (!s->row || !s->used) return t->error.code;
  for (int64_t k = 0; k < s->in.rows && task_is_well(t); k++) {
    if (run_row(t, s, k, wanted)) break;
  }
  return t->error.code;
}

static void clear_study(void *state) {
  study *s = state;
  for (int64_t k = 0; s->row && k < s->in.rows; k++) doc_arena_free(&s->row[k].request_arena);
  study_input_clear(&s->in);
}

/* Writing */

static void write_table(emit *e, const task *t, const void *state) {
  const study *s = state;
  (void)t;
  emit_list(e);
  for (int64_t k = 0; k < s->in.rows; k++) {
    study_row_write(e, &s->row[k], k > 0 ? &s->row[k - 1] : NULL);
  }
  emit_end(e);
}

static void write_reference(emit *e, const task *t, const void *state) {
  const study *s = state;
  (void)t;
  study_paper_write(e, &s->in, s->used);
}

static void write_requests(emit *e, const task *t, const void *state) {
  const study *s = state;
  (void)t;
  emit_list(e);
  for (int64_t k = 0; k < s->in.rows; k++) emit_doc(e, s->row[k].request);
  emit_end(e);
}

const process process_study = {
    .id = "study",
    .inputs = study_inputs,
    .state_size = sizeof(study),
    .read = read_study,
    .memory = memory_of_study,
    .run = run_study,
    .clear = clear_study,
    .outputs = {{"table", NULL, false, write_table},
                {"reference", NULL, true, write_reference},
                {"requests", NULL, false, write_requests},
                {"report", NULL, true, report_write}},
};
