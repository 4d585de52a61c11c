/* flow_input.h - the inputs of process `flow`: a case or a domain, and how it is run.
 * Proof: http.flow, unit.schemas (examples)
 */
#ifndef SCATTERD_FLOW_INPUT_H
#define SCATTERD_FLOW_INPUT_H

#include "flow_domain_input.h"
#include "scatter/flow_case.h"

typedef enum { FLOW_CAVITY, FLOW_STEP, FLOW_DOMAIN } flow_shape;

/* Holds pointers into itself: stays where it is. */
typedef struct {
  flow_shape shape;
  int64_t cells; /* of a case */
  double reynolds, clustering, downstream, end;
  sct_flow_case example; /* of a case, once made */
  flow_domain_input domain;
  flow_field initial; /* of the scalar */
  sct_flow_options options;
} flow_input;

extern const char *const flow_inputs[]; /* names, NULL at the end */

/* Reads all inputs into the zeroed *s; what is wrong becomes complaints. */
void flow_input_read(task *t, const item *in, flow_input *s);

/* Makes domain and options; with t->blame at the input that a failure is the fault of. */
sct_status flow_input_make(task *t, flow_input *s, const sct_flow_domain **domain);
/* Cells of the mesh, about. */
double flow_input_cells(const flow_input *s);
void flow_input_clear(flow_input *s);

#endif
