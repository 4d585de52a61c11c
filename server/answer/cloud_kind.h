/* cloud_kind.h - the forms a cloud is given in; inside cloud_input. */
#ifndef SCATTERD_CLOUD_KIND_H
#define SCATTERD_CLOUD_KIND_H

#include "cloud_input.h"

/* `it` is the whole input. Sets dim, n, posted, and what the form has of spacing and groups. */
bool cloud_posted_read(task *t, const item *it, cloud_input *c);
bool cloud_posted_group(task *t, const item *at, const cloud_input *c, const char *name,
                        point_group *group);

/* `it` is the member `lattice`. */
bool cloud_lattice_read(task *t, const item *it, cloud_input *c);
bool cloud_lattice_group(task *t, const item *at, cloud_input *c, const char *name,
                         point_group *group);

#endif
