/* flow_domain.h - from boxes and sides to cells and faces. */
#ifndef SCATTER_FLOW_DOMAIN_H
#define SCATTER_FLOW_DOMAIN_H

#include "flow_mesh.h"

/* Marks the fluid cells of a mesh whose lines are laid, makes its bounds and ghosts, and checks
 * that they make sense. The status: sct_flow_build. */
SCT_NODISCARD sct_status flow_domain_lay(const sct_flow_domain *domain, flow_mesh *mesh,
                                         sct_error *err);

#endif
