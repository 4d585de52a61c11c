/* stopwatch.h - where the time of one request went. */
#ifndef SCATTERD_STOPWATCH_H
#define SCATTERD_STOPWATCH_H

/* symbol, name in `report.seconds` */
#define LAP_LIST(X)           \
  X(LAP_DECODE, "decode")     \
  X(LAP_SEARCH, "search")     \
  X(LAP_STENCIL, "stencil")   \
  X(LAP_ASSEMBLE, "assemble") \
  X(LAP_FACTOR, "factor")     \
  X(LAP_SOLVE, "solve")       \
  X(LAP_ENCODE, "encode")

#define LAP_ENUM(symbol, name) symbol,
typedef enum { LAP_LIST(LAP_ENUM) LAP_COUNT } lap;
#undef LAP_ENUM

typedef struct {
  double begun, last;        /* (s) on a clock that never steps back */
  double seconds[LAP_COUNT]; /* (s) so far, by lap */
} stopwatch;

const char *lap_name(lap l);

void stopwatch_start(stopwatch *watch);

/* Books the time since the last call (or the start) on `l`. */
void stopwatch_lap(stopwatch *watch, lap l);

/* Moves up to `seconds` of what was booked on `from` to `to`, for calls that do two things and
 * say how long each of them took. */
void stopwatch_move(stopwatch *watch, lap from, lap to, double seconds);

double stopwatch_total(const stopwatch *watch); /* (s) since the start */

#endif
