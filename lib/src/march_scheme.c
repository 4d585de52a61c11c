#include "march_scheme.h"

#include <string.h>

static sct_march_weights forward_euler(double w) {
  (void)w;
  return (sct_march_weights){.implicit = 0, .explicit = 1, .now = 1, .before = 0};
}

static sct_march_weights backward_euler(double w) {
  (void)w;
  return (sct_march_weights){.implicit = 1, .explicit = 0, .now = 1, .before = 0};
}

static sct_march_weights crank_nicolson(double w) {
  (void)w;
  return (sct_march_weights){.implicit = 0.5, .explicit = 0.5, .now = 1, .before = 0};
}

/* The parabola through y'', y, y' has at t' the slope
 *   [ (1 + 2w)/(1 + w) y' - (1 + w) y + w^2/(1 + w) y'' ] / dt = f'. */
static sct_march_weights bdf2(double w) {
  if (w == 0 || w > SCT_BDF2_RATIO) return backward_euler(w);
  const double lead = 1 + 2 * w;
  return (sct_march_weights){.implicit = (1 + w) / lead,
                             .explicit = 0,
                             .now = (1 + w) * (1 + w) / lead,
                             .before = -w * w / lead};
}

static const struct {
  const char *name;
  sct_march_weights (*weigh)(double ratio);
} schemes[SCT_MARCH_COUNT] = {
    [SCT_FORWARD_EULER] = {"forward-euler", forward_euler},
    [SCT_BACKWARD_EULER] = {"backward-euler", backward_euler},
    [SCT_CRANK_NICOLSON] = {"crank-nicolson", crank_nicolson},
    [SCT_BDF2] = {"bdf2", bdf2},
};

sct_march_weights sct_march_weigh(sct_march_method method, double ratio) {
  return schemes[method].weigh(ratio);
}

bool sct_march_uses_old_rate(sct_march_method method) {
  return sct_march_weigh(method, 0).explicit != 0;
}

const char *sct_march_name(sct_march_method method) {
  return (unsigned)method < SCT_MARCH_COUNT ? schemes[method].name : NULL;
}

sct_march_method sct_march_find(const char *name) {
  int k = 0;
  while (k < SCT_MARCH_COUNT && strcmp(schemes[k].name, name) != 0) k++;
  return (sct_march_method)k;
}
