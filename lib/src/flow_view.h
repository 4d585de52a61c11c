/* flow_view.h - inside of the views. */
#ifndef SCATTER_FLOW_VIEW_H
#define SCATTER_FLOW_VIEW_H

#include "flow_inside.h"

/* -psi where psi of the last step is least, at the nodes only. Cost O(cells). */
double flow_circulation(const sct_flow *flow);

#endif
