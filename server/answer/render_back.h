/* render_back.h - what writes a result in one media type: for render.c only.
 *
 * `one` is the output wanted by itself, NULL for the whole result. Each writes behind what there is
 * in out->bytes, may add parameters to out->type, and is false with t->error set.
 */
#ifndef SCATTERD_RENDER_BACK_H
#define SCATTERD_RENDER_BACK_H

#include "grow.h"
#include "render.h"

typedef bool renderer(task *t, const result *r, const result_output *one, rendered *out);

renderer render_json, render_cbor, render_npy, render_vtp, render_csv, render_multipart;

/* In one media type, whatever its renderer is. */
bool render_in(task *t, const result *r, const result_output *one, media form, rendered *out);

/* The type one output has by itself. */
media render_own_form(const result_output *one);

/* A count as stored; what is none becomes -1. */
int32_t render_integer(double value);

/* False, with t->error set. */
bool render_no_memory(task *t);

/* Appends; false with t->error set when out of memory. */
bool put(task *t, rendered *out, const void *bytes, size_t size);
bool put_text(task *t, rendered *out, const char *format, ...) SCT_PRINTF(3, 4);

#endif
