/* process_echo.c - gives back what it is given, after a pause; for trying out clients. */
#include <time.h>

#include "process.h"

static const char *const inputs[] = {"message", "pause", "values", "blob", NULL};
static const char *const texts[] = {"message", "blob", NULL};

typedef struct {
  const char *message;
  double pause; /* (s) */
  numbers values;
} echo;

static void read_echo(task *t, const item *in, void *state) {
  static const range pauses = {0, 60, false, false};
  const int64_t exact = (INT64_C(1) << 53) - 1; /* beyond, two integers are the same double */
  echo *s = state;
  item message = item_input(in, "message"), pause = item_input(in, "pause");
  item values = item_input(in, "values"), blob = item_input(in, "blob");
  const char *ignored;
  if (read_required(t, &message)) read_text(t, &message, &s->message);
  read_number(t, &pause, &pauses, &s->pause);
  read_integers(t, &values, -exact, exact, &s->values);
  read_text(t, &blob, &ignored);
}

/* Sleeps in slices, so that it can be told to stop and progress can be seen. */
static sct_status run_echo(task *t, unsigned wanted, void *state) {
  const echo *s = state;
  const double slice = 0.02, begun = stopwatch_total(&t->watch);
  (void)wanted;
  for (double left = s->pause; left > 0; left = begun + s->pause - stopwatch_total(&t->watch)) {
    const double nap = left < slice ? left : slice;
    nanosleep(&(struct timespec){0, (long)(1e9 * nap)}, NULL);
    if (sct_work_report(&t->work, "pause", 1 - left / s->pause, &t->error)) return t->error.code;
  }
  return SCT_OK;
}

static void write_message(emit *e, const task *t, const void *state) {
  (void)t;
  emit_text(e, ((const echo *)state)->message);
}

static void write_pause(emit *e, const task *t, const void *state) {
  (void)t;
  emit_number(e, ((const echo *)state)->pause);
}

static void write_values(emit *e, const task *t, const void *state) {
  const numbers *values = &((const echo *)state)->values;
  (void)t;
  emit_list(e);
  for (int64_t k = 0; k < values->rows; k++) emit_integer(e, (int64_t)values->data[k]);
  emit_end(e);
}

const process process_echo = {
    .id = "echo",
    .inputs = inputs,
    .texts = texts,
    .state_size = sizeof(echo),
    .read = read_echo,
    .run = run_echo,
    .outputs = {{"message", NULL, false, write_message},
                {"pause", NULL, false, write_pause},
                {"values", NULL, false, write_values, OUTPUT_ARRAY}},
};
