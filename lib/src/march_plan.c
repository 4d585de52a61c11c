#include "march_plan.h"

#include <inttypes.h>
#include <math.h>

static sct_status check_times(const sct_march_options *o, sct_error *err) {
  if (!isfinite(o->start) || !isfinite(o->end) || o->start >= o->end) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "time goes from %g to %g, needs a start before the end", o->start, o->end);
  }
  for (int64_t k = 0; k < o->saves; k++) {
    const double least = k == 0 ? o->start : nextafter(o->save[k - 1], INFINITY);
    if (o->save[k] >= least && o->save[k] <= o->end) continue;
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "save time %" PRId64 " is %.17g, needs ascending times from %g to %g", k,
                    o->save[k], o->start, o->end);
  }
  return SCT_OK;
}

sct_status sct_march_plan_check(const sct_march_options *o, sct_error *err) {
  if ((unsigned)o->method >= SCT_MARCH_COUNT) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "time scheme %d is unknown", (int)o->method);
  }
  if (!isfinite(o->step) || o->step < 0) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "time step is %g, needs to be positive", o->step);
  }
  if (o->step == 0 && !(o->diffusion_number > 0 && isfinite(o->diffusion_number))) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "without a time step the diffusion number is %g, needs to be positive",
                    o->diffusion_number);
  }
  return check_times(o, err);
}

int64_t sct_march_stops(const sct_march_options *o) {
  return o->saves > 0 && o->save[o->saves - 1] == o->end ? o->saves : o->saves + 1;
}

double sct_march_stop(const sct_march_options *o, int64_t k) {
  if (k < 0) return o->start;
  return k < o->saves ? o->save[k] : o->end;
}

double sct_march_steps_over(double length, double dt) {
  return ceil(length / dt * (1 - 1e-10)); /* rounding must not add one */
}

sct_status sct_march_plan_count(const sct_march_options *o, double dt, double *steps,
                                sct_error *err) {
  const double most = o->max_steps > 0 ? (double)o->max_steps : 0x1p53;
  *steps = 0;
  for (int64_t k = 0; k < sct_march_stops(o); k++) {
    *steps += sct_march_steps_over(sct_march_stop(o, k) - sct_march_stop(o, k - 1), dt);
  }
  if (*steps <= most) return SCT_OK;
  return sct_fail(err, SCT_E_LIMIT, -1, "%.0f steps of %g from %g to %g, limit is %.0f", *steps, dt,
                  o->start, o->end, most);
}
