#include "perform.h"

#include "by_href.h"
#include "result.h"

void perform_read(task *t, const process *p, const doc *root, performance *f) {
  *f = (performance){.process = p, .body = item_body(root)};
  f->state = task_zeros(t, 1, p->state_size);
  if (!f->state) return;
  item inputs = item_member(&f->body, "inputs");
  /* those of a batch are its children's */
  if (!p->children && !by_href_resolve(t, &inputs, p->texts)) return;
  execute_read(t, p, &f->body, &f->wanted);
  bool is_readable = !inputs.doc || inputs.doc->kind == DOC_OBJECT;
  if (root->kind == DOC_OBJECT && is_readable) p->read(t, &f->wanted.inputs, f->state);
  stopwatch_lap(&t->watch, LAP_DECODE);
}

static void write_output(emit *e, const task *t, const process_output *output, const void *state) {
  emit_key(e, output->name);
  if (output->is_object) {
    emit_object(e);
    emit_key(e, "value");
  }
  output->write(e, t, state);
  if (output->is_object) emit_end(e);
}

static void write_result(emit *e, const task *t, const performance *f) {
  const execute *x = &f->wanted;
  const bool is_bare = execute_is_bare(x);
  if (!is_bare) emit_object(e);
  for (int k = 0; f->process->outputs[k].name; k++) {
    const process_output *output = &f->process->outputs[k];
    if (!(x->wanted & 1u << k)) continue;
    if (is_bare) output->write(e, t, f->state);
    if (!is_bare) write_output(e, t, output, f->state);
  }
  if (!is_bare) emit_end(e);
}

emit *perform_run(task *t, performance *f, perform_form form) {
  if (!task_is_well(t) || f->process->run(t, f->wanted.wanted, f->state)) return NULL;
  if (!task_is_well(t) || sct_work_report(&t->work, "encode", 0, &t->error)) return NULL;
  emit *e = emit_new(form == PERFORM_JSON ? EMIT_JSON : EMIT_CBOR);
  if (e && form == PERFORM_STORED) result_write(e, t, f);
  if (e && form != PERFORM_STORED) write_result(e, t, f);
  if (e && emit_ok(e)) return e;
  emit_free(&e);
  (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the result");
  return NULL;
}

void perform_clear(performance *f) {
  if (f->state && f->process->clear) f->process->clear(f->state);
}
