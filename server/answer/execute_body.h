/* execute_body.h - the body of an execute request around its inputs: which outputs, in which form,
 * and who wants to know. Proof: unit.answer, unit.render
 */
#ifndef SCATTERD_EXECUTE_BODY_H
#define SCATTERD_EXECUTE_BODY_H

#include "media.h"
#include "process.h"

enum { SUBSCRIBER_CALLS = 3 };

typedef struct {
  unsigned wanted;                          /* bit k: output k of the process */
  unsigned by_reference;                    /* bit k: its transmissionMode */
  media format[PROCESS_OUTPUTS_MAX];        /* of output k; MEDIA_COUNT: none is asked for */
  bool is_raw;                              /* response=raw */
  const char *subscriber[SUBSCRIBER_CALLS]; /* successUri, inProgressUri, failedUri; or NULL */
  item inputs;                              /* not NULL even if absent from the body */
} execute;

/* Reads all of the body but the insides of `inputs`. Outputs left out or empty: all those the
 * inputs allow. What is wrong becomes complaints. `body` must outlive *x. */
void execute_read(task *t, const process *p, const item *body, execute *x);

/* Complains of what only a job, or only a caller that keeps values, can do. */
void execute_refuse_subscriber(task *t, const item *body, const execute *x);
void execute_refuse_references(task *t, const process *p, const item *body, const execute *x);

/* response=raw with one output: its bare value, no document. */
bool execute_is_bare(const execute *x);

#endif
