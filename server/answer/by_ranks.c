#include "by_ranks.h"

#include <stdio.h>
#include <stdlib.h>

#include "member.h"

static void say_alone(by_ranks *r, const char *reason) {
  snprintf(r->alone, sizeof r->alone, "%.*s", (int)sizeof r->alone - 1, reason);
}

/* Why this request is for one process; NULL: it can be shared. */
static const char *reason_of(const task *t, const performance *f) {
  if (!f->process->alone) return "this process is not run in parallel";
  return f->process->alone(t, f->state);
}

bool by_ranks_begin(task *t, const performance *f) {
  by_ranks *r = t->ranks;
  if (!r || !task_is_well(t)) return true; /* what is wrong with it all ranks see */
  const char *reason = reason_of(t, f);
  sct_error error = {.code = SCT_OK};
  if (!reason && sct_ranks_open(&r->group, &error)) reason = error.text;
  if (!reason) return true;
  say_alone(r, reason);
  r->leaves = r->rank > 0;
  if (!r->leaves) sct_ranks_alone();
  return !r->leaves;
}

bool by_ranks_disband(task *t, const char *reason) {
  by_ranks *r = t->ranks;
  if (reason) say_alone(r, reason);
  r->leaves = r->rank > 0;
  r->disbanded = true;
  return !r->leaves;
}

by_ranks *answer_ranks_new(void) {
  by_ranks *r = calloc(1, sizeof *r);
  if (r) (void)sct_ranks_place(&r->rank, &r->count);
  return r;
}

int answer_ranks_place(const by_ranks *r) {
  return r->rank;
}

/* Refusals all ranks have, so one tells them. */
answer_role answer_ranks_role(const by_ranks *r) {
  if (r->group && !r->disbanded) return ANSWER_STUCK;
  return r->leaves || r->rank > 0 ? ANSWER_LEAVES : ANSWER_REPLIES;
}

void answer_ranks_free(by_ranks **r) {
  sct_ranks_close(&(*r)->group);
  free(*r);
  *r = NULL;
}

void by_ranks_write(emit *e, const task *t) {
  const by_ranks *r = t->ranks;
  if (!r) return;
  member_object(e, "ranks");
  member_integer(e, "count", *r->alone ? 1 : r->count);
  if (*r->alone) {
    member_text(e, "reason", r->alone);
  } else {
    member_integer(e, "points_most", r->report.own_most);
    member_integer(e, "halo_most", r->report.halo_most);
    member_integer(e, "halo", r->report.halo);
    member_integer(e, "rounds", r->report.rounds);
  }
  emit_end(e);
}
