/* flow_case.h - the two flows that the method is measured by: lid-driven cavity and backward-facing
 * step ([H16] section 4.4), as domains and options of flow.h. Nothing in a flow knows of them.
 */
#ifndef SCATTER_FLOW_CASE_H
#define SCATTER_FLOW_CASE_H

#include "scatter/flow.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Lines of a mesh: n cells from `lower` to `upper`, x = lower + L (t - (a / 2 pi) sin 2 pi t),
 * which are narrower at both ends by the factor 1 - a and wider between by 1 + a; a in [0, 0.9].
 * edge [n + 1] out, the ends exact. */
void sct_flow_lines(double lower, double upper, int64_t n, double clustering, double *edge);

/* A domain with its memory, and the options it is run with. Points into itself: not to be copied.
 */
typedef struct {
  sct_flow_domain domain;
  sct_flow_options options;
  double *edge[2];
  sct_flow_box solid;
  sct_flow_side side[4];
  double inlet[2];    /* lower and upper end of the inlet of the step */
  double step_height; /* 0: cavity */
} sct_flow_case;

/* Unit square with a lid of speed 1, nu = 1 / reynolds, shift 0.25; `cells` per side, clustered at
 * the walls if `clustering` > 0. SCT_E_ARGUMENT for cells below 4 or above 4096, clustering outside
 * [0, 0.9], reynolds or end not positive; SCT_E_MEMORY. Clear in any case. */
SCT_NODISCARD sct_status sct_flow_cavity(int64_t cells, double reynolds, double clustering,
                                         sct_scheme scheme, double end, sct_flow_case *flow,
                                         sct_error *err);

/* Channel of height 1 and length 2 before, `downstream` behind, a step of height 0.942, parabola of
 * mean 1 at the inlet, nu = 2 / reynolds, shift 0.5; `cells` over the inlet's height and about as
 * high ones below. With clustering > 0 lines are clustered at
 * floor, edge and ceiling, and in x cells are 0.85 / cells wide around the step and grow to twice
 * that by 1.03^(17 / cells). Failures as above. */
SCT_NODISCARD sct_status sct_flow_step(int64_t cells, double reynolds, double clustering,
                                       double downstream, sct_scheme scheme, double end,
                                       sct_flow_case *flow, sct_error *err);
void sct_flow_case_clear(sct_flow_case *c);

#ifdef __cplusplus
}
#endif
#endif
