/* execute_body.h - the body of an execute request around its inputs: which outputs, in which form.
 */
#ifndef SCATTERD_EXECUTE_BODY_H
#define SCATTERD_EXECUTE_BODY_H

#include "media.h"
#include "process.h"

typedef struct {
  unsigned wanted; /* bit k: output k of the process */
  bool is_raw;     /* response=raw with one output: its bare value, no document */
  item inputs;     /* not NULL even if absent from the body */
} execute;

/* Reads all of the body but the insides of `inputs`. Outputs left out or empty: all those the
 * inputs allow. What is wrong becomes complaints. `body` must outlive *x. */
void execute_read(task *t, const process *p, const item *body, media accept, execute *x);

#endif
