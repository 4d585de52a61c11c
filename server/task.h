/* task.h - one request at work: its limits, its memory, and everything found wrong with it.
 *
 * Two kinds of failure are kept apart. What the client can mend in the body is a complaint: it
 * points to a value, and reading goes on to find the others (HTTP 400). What only turns out while
 * solving is the sct_error of the library call that failed.
 */
#ifndef SCATTERD_TASK_H
#define SCATTERD_TASK_H

#include <stdarg.h>

#include "doc.h"
#include "limits.h"
#include "scatter/status.h"
#include "stopwatch.h"

enum { COMPLAINTS_MAX = 20 };

typedef struct {
  const char *pointer; /* JSON pointer to the culprit */
  const char *detail;  /* subject, got, needed */
} complaint;

typedef struct language language;

typedef struct {
  const limits *limits;
  doc_arena *arena;      /* everything of this request; freed in one go after the reply */
  sct_work work;         /* for library calls: threads, and who is told */
  stopwatch watch;       /* where the time goes */
  language *language;    /* of expressions; NULL until there is one */
  const doc *parameters; /* object of numbers that expressions may name, or NULL */

  int64_t complaints; /* found in all; the first COMPLAINTS_MAX are kept */
  complaint complaint[COMPLAINTS_MAX];
  sct_error error; /* of the library call that failed */
} task;

/* Memory for n >= 0 items that lives as long as the request; NULL with t->error set
 * (SCT_E_MEMORY) when there is none. task_zeros: filled with zero bytes. */
void *task_take(task *t, int64_t n, size_t size);
void *task_zeros(task *t, int64_t n, size_t size);

/* Text that lives as long as the request; NULL as above. */
char *task_text(task *t, const char *format, ...) SCT_PRINTF(2, 3);
char *task_vtext(task *t, const char *format, va_list list);

/* Nothing found wrong so far. */
bool task_is_well(const task *t);

#endif
