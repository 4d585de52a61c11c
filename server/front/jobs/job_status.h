/* job_status.h - statusInfo documents of jobs: writing, replying. Test: http.jobs.
 */
#ifndef SCATTERD_JOB_STATUS_H
#define SCATTERD_JOB_STATUS_H

#include "emit.h"
#include "exchange.h"
#include "job.h"

/* The document as a value; links begin with `base`. `minimal`: only what the standard requires.
 * `s` is where its log comes from, NULL: without. */
void job_status_emit(emit *e, const job_view *view, const char *base, bool minimal, store *s);

/* The same as text, malloc'ed; NULL when out of memory. */
char *job_status_bytes(const job_view *view, const char *base, bool minimal, store *s,
                       size_t *size);

/* Replies with it. */
void job_status_reply(exchange *x, int status, const job_view *view, bool minimal, store *s);

/* Entity tag of a document, with its quotes. */
void job_status_tag(const char *bytes, size_t size, char tag[24]);

/* A time as RFC 3339 has it, in UTC with milliseconds. */
void job_status_time(double seconds, char text[32]);

/* Problems: there is no such job; it is dismissed; its result is not there yet; its own. */
void job_refuse_missing(exchange *x, const char *id);
void job_refuse_dismissed(exchange *x, const char *id);
void job_refuse_unready(exchange *x, const job_row *row);
void job_refuse_failed(exchange *x, jobs *j, const job_row *row);
void job_refuse_store(exchange *x, store_result why);

#endif
