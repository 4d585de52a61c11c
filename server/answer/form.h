/* form.h - the forms a result can take: which media types a whole result, and one output by itself,
 * can be had in. One table (form.c). The front refuses what no process could give, before a body is
 * sent; here is chosen by what the request asks for.
 * Proof: unit.render
 */
#ifndef SCATTERD_FORM_H
#define SCATTERD_FORM_H

#include "media.h"
#include "process.h"

/* Can one output of that role be had in this media type? */
bool form_fits_output(media m, output_role role);

/* Can a result with outputs of these roles (bit per role)? */
bool form_fits_result(media m, unsigned roles);

/* The media types of one output, and of a result, in the order of our own preference; returns how
 * many. */
int forms_for_output(output_role role, media list[MEDIA_COUNT]);
int forms_for_result(unsigned roles, media list[MEDIA_COUNT]);

/* "application/json, text/csv or ..." for a message. */
void forms_of_output(output_role role, char *room, size_t size);
void forms_of_result(unsigned roles, char *room, size_t size);

#endif
