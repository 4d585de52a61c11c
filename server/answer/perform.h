/* perform.h - one decoded execute request, from its document to an encoded result.
 *
 * What `answer` does between decoding and replying. A process that runs requests of other processes
 * (study) does the same with tasks of its own, so that there is one way to run a request.
 * Proof: unit.answer
 */
#ifndef SCATTERD_PERFORM_H
#define SCATTERD_PERFORM_H

#include "execute_body.h"
#include "ipc.h"

typedef struct {
  const process *process;
  item body; /* stays where it is: the inputs point to it */
  execute wanted;
  void *state; /* of the process; in the arena of the task */
} performance;

/* Reads and checks the whole request; what is wrong is in t->complaints or t->error. */
void perform_read(task *t, const process *p, const doc *root, performance *f);

/* Runs it and writes the result; the caller frees it. NULL if the task was not well, or is not any
 * more. JSON and CBOR: the result document, or the one bare value; STORED: see result.h. */
typedef enum { PERFORM_JSON, PERFORM_CBOR, PERFORM_STORED } perform_form;
emit *perform_run(task *t, performance *f, perform_form form);

/* Frees what the process holds; after perform_read, run or not. */
void perform_clear(performance *f);

#endif
