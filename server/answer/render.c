#include "render.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "form.h"
#include "render_back.h"

/* Putting bytes */

bool render_no_memory(task *t) {
  (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the result");
  return false;
}

bool put(task *t, rendered *out, const void *bytes, size_t size) {
  char *room = grow_room(&out->bytes, size);
  if (!room) return render_no_memory(t);
  if (size > 0) memcpy(room, bytes, size);
  out->bytes.size += size;
  return true;
}

bool put_text(task *t, rendered *out, const char *format, ...) {
  char text[2048];
  va_list list;
  va_start(list, format);
  int length = vsnprintf(text, sizeof text, format, list);
  va_end(list);
  if (length >= (int)sizeof text) length = (int)sizeof text - 1; /* no text here is that long */
  return put(t, out, text, (size_t)length);
}

int32_t render_integer(double value) {
  return value >= 0 && value <= INT32_MAX ? (int32_t)value : -1;
}

/* Forms */

static renderer *const renderers[MEDIA_COUNT] = {
    [MEDIA_JSON] = render_json, [MEDIA_CBOR] = render_cbor, [MEDIA_NPY] = render_npy,
    [MEDIA_VTP] = render_vtp,   [MEDIA_CSV] = render_csv,   [MEDIA_MULTIPART] = render_multipart,
};

bool render_in(task *t, const result *r, const result_output *one, media form, rendered *out) {
  snprintf(out->type, sizeof out->type, "%s", media_type(form));
  return renderers[form](t, r, one, out);
}

media render_own_form(const result_output *one) {
  return one->format == MEDIA_COUNT ? MEDIA_JSON : one->format;
}

static media refuse_form(problem *refusal, const char *what, const char *known) {
  problem_begin(refusal, 406, "Accept: takes no form of %s, needs %s", what, known);
  return MEDIA_COUNT;
}

/* The form of one output by itself: what it was asked to be, if the client takes that. */
static media form_of_one(const char *name, output_role role, media asked, const wishes *accept,
                         problem *refusal) {
  media list[MEDIA_COUNT];
  char known[256];
  if (asked != MEDIA_COUNT && media_pick(accept, &asked, 1) == asked) return asked;
  media form = media_pick(accept, list, forms_for_output(role, list));
  if (form != MEDIA_COUNT) return form;
  forms_of_output(role, known, sizeof known);
  return refuse_form(refusal, name, known);
}

static media form_of_all(unsigned roles, const wishes *accept, problem *refusal) {
  media list[MEDIA_COUNT];
  char known[256];
  media form = media_pick(accept, list, forms_for_result(roles, list));
  if (form != MEDIA_COUNT) return form;
  forms_of_result(roles, known, sizeof known);
  return refuse_form(refusal, "these outputs together", known);
}

media render_form(const process *p, const execute *x, const wishes *accept, problem *refusal) {
  unsigned roles = 0;
  for (int k = 0; p->outputs[k].name; k++) {
    if (!(x->wanted & 1u << k)) continue;
    const process_output *o = &p->outputs[k];
    roles |= 1u << o->role;
    if (execute_is_bare(x)) return form_of_one(o->name, o->role, x->format[k], accept, refusal);
  }
  return form_of_all(roles, accept, refusal);
}

/* References */

/* Keeps a value and notes where it can be had. */
static bool keep(task *t, const result *r, const ask_calls *calls, result_output *o,
                 problem *refusal) {
  rendered own = {0};
  ask_kept *at = task_zeros(t, 1, sizeof *at);
  bool done = at && render_in(t, r, o, render_own_form(o), &own);
  if (done) {
    calls->keep(calls->context, own.type, own.bytes.data, own.bytes.size, at);
    done = at->status == 200;
    if (!done) problem_begin(refusal, at->status, "output %s: %s", o->name, at->detail);
    o->href = at->href;
  }
  free(own.bytes.data);
  return done;
}

static bool find_references(task *t, result *r, const render_wish *w, problem *refusal) {
  bool is_kept = w->results_url && *w->results_url;
  for (int k = 0; k < r->count; k++) {
    result_output *o = &r->output[k];
    if (!o->by_reference) continue;
    if (!is_kept) {
      if (!keep(t, r, w->calls, o, refusal)) return false;
      continue;
    }
    size_t room = strlen(w->results_url) + strlen(o->name) + 2;
    char *href = task_take(t, (int64_t)room, 1);
    if (!href) return false;
    snprintf(href, room, "%s/%s", w->results_url, o->name);
    o->href = href;
  }
  return true;
}

static bool all_by_reference(const result *r) {
  for (int k = 0; k < r->count; k++) {
    if (!r->output[k].by_reference) return false;
  }
  return r->count > 0;
}

static bool render_links(task *t, const result *r, rendered *out) {
  out->status = 204;
  *out->type = '\0';
  for (int k = 0; k < r->count; k++) {
    const result_output *o = &r->output[k];
    if (!put_text(t, out, "<%s>; rel=\"%s\"; type=\"%s\"\n", o->href, o->name,
                  media_type(render_own_form(o)))) {
      return false;
    }
  }
  return true;
}

/* The whole */

static bool refuse_output(const result *r, const char *name, problem *refusal) {
  problem_begin(refusal, 404, "the results have no output \"%.60s\"; the first they have is \"%s\"",
                name, r->count > 0 ? r->output[0].name : "");
  return false;
}

static bool render_one(task *t, const result *r, const result_output *one, const wishes *accept,
                       rendered *out, problem *refusal) {
  media form = form_of_one(one->name, one->role, one->format, accept, refusal);
  return form != MEDIA_COUNT && render_in(t, r, one, form, out);
}

static bool render_all(task *t, result *r, const render_wish *w, rendered *out, problem *refusal) {
  if (!find_references(t, r, w, refusal)) return false;
  if (r->is_raw && all_by_reference(r)) return render_links(t, r, out);
  if (r->is_raw && r->count == 1) {
    return render_one(t, r, &r->output[0], &w->accept, out, refusal);
  }
  media form = form_of_all(result_roles(r), &w->accept, refusal);
  return form != MEDIA_COUNT && render_in(t, r, NULL, form, out);
}

bool render(task *t, result *r, const render_wish *w, rendered *out, problem *refusal) {
  out->status = 200;
  if (!w->output || !*w->output) return render_all(t, r, w, out, refusal);
  const result_output *one = result_find(r, w->output);
  return one ? render_one(t, r, one, &w->accept, out, refusal)
             : refuse_output(r, w->output, refusal);
}
