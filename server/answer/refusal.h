/* refusal.h - what went wrong with a request, as its reply: one table from sct_status to HTTP.
 * Proof: unit.answer
 */
#ifndef SCATTERD_REFUSAL_H
#define SCATTERD_REFUSAL_H

#include "answer.h"
#include "task.h"

/* Makes a problem the reply. */
void refuse(reply *r, const problem *p);

/* The problem of a task that is not well: its complaints (400), else its error. */
void refuse_task(reply *r, task *t);

#endif
