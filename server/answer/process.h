/* process.h - the table of processes: what each reads, does and hands out. */
#ifndef SCATTERD_PROCESS_H
#define SCATTERD_PROCESS_H

#include "emit.h"
#include "read.h"

enum { PROCESS_OUTPUTS_MAX = 16 };

/* An output, in the order of the result document. */
typedef struct {
  const char *name;
  const char *needs; /* one of these inputs, separated by spaces; NULL: always there */
  bool is_object;    /* stands under "value" in a document */
  /* Writes the value: what `run` left in the state, [n] in the client's numbers. */
  void (*write)(emit *e, const task *t, const void *state);
} process_output;

/* `wanted` has bit k set where output k is selected. State lives in the arena of the task; what a
 * state holds beyond it, `clear` frees. */
typedef struct {
  const char *id;
  const char *const *inputs; /* known names, NULL at the end */
  size_t state_size;
  /* Decodes and checks the inputs into the zeroed state: all culprits become complaints. */
  void (*read)(task *t, const item *inputs, void *state);
  /* Does the work. Not called if anything is wrong. */
  sct_status (*run)(task *t, unsigned wanted, void *state);
  void (*clear)(void *state);                  /* after reading, run or not; may be NULL */
  process_output outputs[PROCESS_OUTPUTS_MAX]; /* name NULL at the end */
} process;

/* The process called `id`, or NULL; and number k of the table, NULL past its end. */
const process *process_find(const char *id);
const process *process_at(int k);

extern const process process_solve, process_apply, process_diagnose, process_study, process_echo;

#endif
