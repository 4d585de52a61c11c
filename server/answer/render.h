/* render.h - a stored result as the bytes a client gets: the whole, or one output, by its wishes.
 *
 * Without an output the form follows the request that made the result: response=document gives the
 * results document; response=raw with one output its bare value, with several multipart/related to
 * a client that asks for it, else the document. What is wanted by reference stands as {"href",
 * "type"}; if response=raw leaves nothing but references, the status is 204 and the bytes are the
 * values of Link fields, one a line (OGC API - Processes 1.0, requirements 30 to 34).
 * Proof: unit.render, http.results
 */
#ifndef SCATTERD_RENDER_H
#define SCATTERD_RENDER_H

#include "answer.h"
#include "grow.h"
#include "result.h"

typedef struct {
  const char *output;      /* NULL or "": what the request asked for */
  const char *results_url; /* where references point into; NULL or "": values are kept one by one */
  wishes accept;
  const ask_calls *calls; /* keep */
} render_wish;

typedef struct {
  int status;
  char type[128];
  grow_bytes bytes; /* free .data */
} rendered;

/* False with *refusal or t->error set; 404 for an output that is not there, 406 where no form of it
 * is wanted. */
bool render(task *t, result *r, const render_wish *wish, rendered *out, problem *refusal);

/* The form a request will be answered in, by its outputs; MEDIA_COUNT with *refusal (406) set. */
media render_form(const process *p, const execute *x, const wishes *accept, problem *refusal);

#endif
