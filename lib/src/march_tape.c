#include "march_tape.h"

#include <string.h>

#include "alloc.h"
#include "march_scheme.h"

sct_status sct_tape_start(sct_tape *tape, sct_march_method method, const sct_system *system,
                          double steps, sct_error *err) {
  if (tape == NULL) return SCT_OK;
  if (system->limited != NULL) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "a march with upwind limited is not linear and cannot be recorded");
  }
  const double levels = steps + 2; /* one more than planned, should rounding shorten a last step */
  const double bytes =
      levels * (double)sizeof(double) * (2 + (tape->keeps_values ? (double)system->n : 0));
  if (tape->most_bytes > 0 && bytes > (double)tape->most_bytes) {
    return sct_fail(err, SCT_E_LIMIT, -1,
                    "%.0f steps of %lld values are %.0f bytes to remember, limit is %lld; take "
                    "longer steps or fewer points",
                    steps, (long long)system->n, bytes, (long long)tape->most_bytes);
  }
  sct_tape_clear(tape);
  tape->n = system->n;
  tape->room = (int64_t)levels;
  tape->is_settled = sct_march_uses_old_rate(method);
  sct_status status = sct_alloc(&tape->t, tape->room, sizeof *tape->t, err);
  if (status == SCT_OK) status = sct_alloc(&tape->dt, tape->room, sizeof *tape->dt, err);
  if (status == SCT_OK && tape->keeps_values) {
    status = sct_alloc(&tape->phi, tape->room, (size_t)tape->n * sizeof *tape->phi, err);
  }
  return status;
}

void sct_tape_record(sct_tape *tape, const sct_system *system, double t, double dt,
                     const double *phi, const double *y) {
  if (tape == NULL || tape->levels == tape->room) return;
  const int64_t k = tape->levels++;
  tape->t[k] = t;
  tape->dt[k] = dt;
  if (tape->phi == NULL) return;
  double *values = tape->phi + k * tape->n;
  memcpy(values, phi, (size_t)tape->n * sizeof *values);
  for (int64_t i = 0; i < system->unknowns; i++) values[system->point_of[i]] = y[i];
}

void sct_tape_clear(sct_tape *tape) {
  sct_release(&tape->t);
  sct_release(&tape->dt);
  sct_release(&tape->phi);
  tape->levels = tape->room = 0;
}
