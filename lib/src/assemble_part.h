/* assemble_part.h - assembly of a part of a cloud, of which the whole has to be known. */
#ifndef SCATTER_ASSEMBLE_PART_H
#define SCATTER_ASSEMBLE_PART_H

#include "scatter/assemble.h"

/* sct_system_build, where some diffusivity is positive that need not be among these: rows without
 * any are made differently if nothing diffuses at all. */
SCT_NODISCARD sct_status sct_system_build_part(const sct_stencil *stencil, const sct_fields *fields,
                                               const sct_boundary *boundary, bool diffuses,
                                               const sct_work *work, sct_system **system,
                                               sct_error *err);

#endif
