/* status.h - what a library call answers: a code, and on request the whole story.
 *
 * Every function that can fail returns an sct_status and takes, as its last
 * argument, an sct_error to fill. The error may be NULL. It is filled once, where
 * the fact is known; callers pass it on untouched. There is no global state.
 */
#ifndef SCATTER_STATUS_H
#define SCATTER_STATUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define SCT_NODISCARD __attribute__((warn_unused_result))
#define SCT_PRINTF(f, a) __attribute__((format(printf, f, a)))
#else
#define SCT_NODISCARD
#define SCT_PRINTF(f, a)
#endif

/* code, name, text */
#define SCT_STATUS_LIST(X)                                           \
  X(SCT_OK, "ok", "done")                                            \
  X(SCT_E_ARGUMENT, "argument", "bad argument")                      \
  X(SCT_E_MEMORY, "memory", "out of memory")                         \
  X(SCT_E_LIMIT, "limit", "size limit exceeded")                     \
  X(SCT_E_NOT_FINITE, "not-finite", "value is not finite")           \
  X(SCT_E_COINCIDENT, "coincident", "coincident points")             \
  X(SCT_E_DEFICIENT, "deficient", "deficient neighbourhood")         \
  X(SCT_E_SINGULAR, "singular", "singular system")                   \
  X(SCT_E_UNSTABLE, "unstable", "unstable time step")                \
  X(SCT_E_CONVERGENCE, "convergence", "iteration does not converge") \
  X(SCT_E_CANCELLED, "cancelled", "cancelled by the caller")

typedef enum {
#define SCT_STATUS_ENUM(code, name, text) code,
  SCT_STATUS_LIST(SCT_STATUS_ENUM)
#undef SCT_STATUS_ENUM
      SCT_STATUS_COUNT
} sct_status;

enum { SCT_ERROR_POINTS = 20, SCT_ERROR_TEXT = 512 };

/* A failure. Where it is about a point, the text is what is to be said of it ("has 4 neighbours,
 * needs 6") and the number stands in `point`, so that a caller who renumbered the points can
 * number them back before sct_error_message puts the two together. */
typedef struct {
  sct_status code;
  int64_t point;                    /* point concerned, or -1 */
  int64_t count;                    /* how many points are concerned in all (0: none) */
  int64_t points[SCT_ERROR_POINTS]; /* the first of them */
  char text[SCT_ERROR_TEXT];        /* got, needed; with the subject unless that is the point */
} sct_error;

/* How a long call works: threads to use and whom to tell. NULL means one thread, nobody.
 * `report` is called between pieces of work, from one thread only, with the fraction in
 * [0, 1] of the named phase; if it returns false the call ends with SCT_E_CANCELLED. `residual`
 * hears of every step of an iteration (what it is, the call says), before the report that follows
 * it. Either may be NULL. */
typedef struct {
  int threads; /* <= 1: one */
  bool (*report)(void *context, const char *phase, double fraction);
  void *context;
  void (*residual)(void *context, double value);
} sct_work;

/* Name ("singular") and sentence ("singular system") of a code. Never NULL. Proof: unit.status */
const char *sct_status_name(sct_status code);
const char *sct_status_text(sct_status code);

/* Fills `err` (if any) and returns `code`, so that a failure is one line:
 *   return sct_fail(err, SCT_E_ARGUMENT, -1, "dimension is %d, needs 1 to 3", dim);
 * Proof: unit.status */
sct_status sct_fail(sct_error *err, sct_status code, int64_t point, const char *format, ...)
    SCT_PRINTF(4, 5);

/* Adds `point`, or the points of another failure, to the list of points of an error in the
 * making: count grows without bound, the first SCT_ERROR_POINTS are kept. sct_error_merge into an
 * error without code copies it whole. `err`, `into` may be NULL. Proof: unit.status */
void sct_error_add_point(sct_error *err, int64_t point);
void sct_error_merge(sct_error *into, const sct_error *from);

/* The whole sentence: "point 17 has 4 neighbours, needs 6 (and 3 more points: 18, 19, 20)".
 * Returns room [size]. Proof: unit.status */
const char *sct_error_message(const sct_error *err, char *room, size_t size);

/* Threads that `work` asks for, at least 1. */
int sct_work_threads(const sct_work *work);

/* Tells `work` (if any) where the call stands; SCT_E_CANCELLED if it wants no more. */
void sct_work_residual(const sct_work *work, double value);
SCT_NODISCARD sct_status sct_work_report(const sct_work *work, const char *phase, double fraction,
                                         sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
