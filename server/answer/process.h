/* process.h - the table of processes: what each reads, does and hands out. */
#ifndef SCATTERD_PROCESS_H
#define SCATTERD_PROCESS_H

#include "emit.h"
#include "grow.h"
#include "read.h"

enum { PROCESS_OUTPUTS_MAX = 16 };

/* What an output is, for the forms a result can take. */
typedef enum {
  OUTPUT_OTHER,
  OUTPUT_ARRAY,       /* an array of numbers */
  OUTPUT_COORDINATES, /* [n][dim]: where the rows of the following are */
  OUTPUT_FIELD,       /* [n] or [n][components] */
  OUTPUT_COUNTS,      /* [n], integers */
  OUTPUT_TENSOR       /* [n][dim (dim + 1) / 2]: xx, xy, .. of a symmetric one */
} output_role;

/* An output, in the order of the result document. */
typedef struct {
  const char *name;
  const char *needs; /* one of these inputs ("case=step": with that text), separated by spaces;
                        NULL: always there */
  bool is_object;    /* stands under "value" in a document */
  /* Writes the value: what `run` left in the state, [n] in the client's numbers. */
  void (*write)(emit *e, const task *t, const void *state);
  output_role role;
} process_output;

/* `wanted` has bit k set where output k is selected. State lives in the arena of the task; what a
 * state holds beyond it, `clear` frees. */
typedef struct {
  const char *id;
  const char *const *inputs; /* known names, NULL at the end */
  const char *const *texts;  /* those of them that are texts, NULL at the end; NULL: none */
  size_t state_size;
  /* Decodes and checks the inputs into the zeroed state: all culprits become complaints. */
  void (*read)(task *t, const item *inputs, void *state);
  /* Does the work. Not called if anything is wrong. */
  sct_status (*run)(task *t, unsigned wanted, void *state);
  void (*clear)(void *state); /* after reading, run or not; may be NULL */
  /* Estimated peak of `run`, (bytes) beyond the worker's own; NULL: nothing to speak of. */
  int64_t (*memory)(const task *t, const void *state);
  /* Why what was read is not for several processes together (by_ranks.h), NULL: it is; a process
   * without this is for one always. */
  const char *(*alone)(const task *t, const void *state);
  /* Of a batch: writes the frames of its children (check.h); NULL: it has none. */
  bool (*children)(task *t, const void *state, grow_bytes *frames);
  /* Where the fields are, also when no output says so; NULL where there are no fields. */
  void (*coordinates)(emit *e, const task *t, const void *state);
  process_output outputs[PROCESS_OUTPUTS_MAX]; /* name NULL at the end */
} process;

/* The process called `id`, or NULL; and number k of the table, NULL past its end. */
const process *process_find(const char *id);
const process *process_at(int k);

extern const process process_solve, process_apply, process_diagnose, process_study, process_flow,
    process_echo, process_batch;

#endif
