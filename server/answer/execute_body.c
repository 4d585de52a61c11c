#include "execute_body.h"

#include <string.h>

#include "form.h"
#include "ipc.h"

/* Is there an input of that name, or, "name=text", one with that text? */
static bool has(const item *inputs, char *name) {
  char *text = strchr(name, '=');
  if (text) *text++ = '\0';
  const doc *input = item_input(inputs, name).doc;
  return input && (!text || (input->kind == DOC_TEXT && !strcmp(input->text, text)));
}

/* Does `list`, names with spaces between, name something that is among the inputs? */
static bool has_one_of(const item *inputs, const char *list) {
  char name[64];
  for (const char *c = list; *c; c += strspn(c, " ")) {
    size_t length = strcspn(c, " ");
    if (length >= sizeof name) return false;
    memcpy(name, c, length);
    name[length] = '\0';
    if (has(inputs, name)) return true;
    c += length;
  }
  return false;
}

static bool is_available(const process_output *output, const item *inputs) {
  return !output->needs || has_one_of(inputs, output->needs);
}

static unsigned all_available(const process *p, const item *inputs) {
  unsigned wanted = 0;
  for (int k = 0; p->outputs[k].name; k++) {
    if (is_available(&p->outputs[k], inputs)) wanted |= 1u << k;
  }
  return wanted;
}

static void output_names(const process *p, const char *names[PROCESS_OUTPUTS_MAX + 1]) {
  int n = 0;
  while (n < PROCESS_OUTPUTS_MAX && p->outputs[n].name) {
    names[n] = p->outputs[n].name;
    n++;
  }
  names[n] = NULL;
}

static bool read_transmission(task *t, const item *output) {
  static const char *const modes[] = {"value", "reference", NULL};
  item mode = item_member(output, "transmissionMode");
  int chosen = 0;
  (void)read_choice(t, &mode, modes, &chosen);
  return chosen == 1;
}

/* The format asked for, MEDIA_COUNT if none is. */
static media read_format(task *t, const item *output, output_role role) {
  item format = item_member(output, "format"), type = item_member(&format, "mediaType");
  const char *name = NULL;
  char room[SHOWN_MAX], known[256];
  media wanted;
  if (!read_object(t, &format, NULL) || !read_text(t, &type, &name) || !name) return MEDIA_COUNT;
  if (media_find(name, &wanted) && form_fits_output(wanted, role)) return wanted;
  forms_of_output(role, known, sizeof known);
  complain(t, &type, "is \"%s\", needs %s", shown(name, room), known);
  return MEDIA_COUNT;
}

static void read_output(task *t, const process *p, const item *it, execute *x) {
  static const char *const members[] = {"transmissionMode", "format", NULL};
  const char *names[PROCESS_OUTPUTS_MAX + 1];
  int k = 0;
  while (p->outputs[k].name && strcmp(p->outputs[k].name, it->key)) k++;
  if (!p->outputs[k].name) {
    output_names(p, names);
    complain_unknown(t, it, "output", names);
    return;
  }
  if (read_object(t, it, members)) {
    if (read_transmission(t, it)) x->by_reference |= 1u << k;
    x->format[k] = read_format(t, it, p->outputs[k].role);
  }
  if (!is_available(&p->outputs[k], &x->inputs)) {
    complain(t, it, "cannot be had without an input of: %s", p->outputs[k].needs);
  }
  x->wanted |= 1u << k;
}

static void read_outputs(task *t, const process *p, const item *it, execute *x) {
  bool is_given = read_object(t, it, NULL) && it->doc && it->doc->count > 0;
  if (!is_given) {
    x->wanted = all_available(p, &x->inputs);
    return;
  }
  for (const doc *m = it->doc->child; m; m = m->next) {
    item output = {.doc = m, .up = it, .key = m->key};
    read_output(t, p, &output, x);
  }
}

/* What stands beside the value of qualified inputs. */
static void read_qualifiers(task *t, const item *inputs) {
  if (!inputs->doc || inputs->doc->kind != DOC_OBJECT) return;
  for (const doc *m = inputs->doc->child; m; m = m->next) {
    item input = {.doc = m, .up = inputs, .key = m->key};
    read_qualified(t, &input);
  }
}

/* A subscriber without addresses asks for nothing. Which hosts may be called is the front's matter.
 */
static const char *const calls[SUBSCRIBER_CALLS] = {"successUri", "inProgressUri", "failedUri"};

static void read_subscriber(task *t, const item *it, execute *x) {
  char room[SHOWN_MAX];
  if (!read_object(t, it, NULL)) return;
  for (int k = 0; k < SUBSCRIBER_CALLS; k++) {
    item call = item_member(it, calls[k]);
    const char *url = NULL;
    if (!read_text(t, &call, &url) || !url) continue;
    bool is_url = !strncmp(url, "http://", 7) || !strncmp(url, "https://", 8);
    if (!is_url || strlen(url) >= IPC_URL) {
      complain(t, &call, "is \"%s\", needs a URL of http or https", shown(url, room));
    }
    x->subscriber[k] = url;
  }
}

void execute_refuse_subscriber(task *t, const item *body, const execute *x) {
  item it = item_member(body, "subscriber");
  for (int k = 0; k < SUBSCRIBER_CALLS; k++) {
    item call = item_member(&it, calls[k]);
    if (x->subscriber[k]) complain(t, &call, "asks to be called back, needs Prefer: respond-async");
  }
}

void execute_refuse_references(task *t, const process *p, const item *body, const execute *x) {
  item outputs = item_member(body, "outputs");
  for (int k = 0; k < PROCESS_OUTPUTS_MAX; k++) {
    if (!(x->by_reference & 1u << k)) continue;
    item output = item_member(&outputs, p->outputs[k].name);
    item mode = item_member(&output, "transmissionMode");
    complain(t, &mode, "is \"reference\", needs value: nothing keeps results here");
  }
}

bool execute_is_bare(const execute *x) {
  return x->is_raw && x->wanted && !(x->wanted & (x->wanted - 1));
}

void execute_read(task *t, const process *p, const item *body, execute *x) {
  static const char *const responses[] = {"document", "raw", NULL};
  item outputs = item_member(body, "outputs"), response = item_member(body, "response");
  item subscriber = item_member(body, "subscriber");
  int chosen = 0;
  *x = (execute){.inputs = item_member(body, "inputs")};
  for (int k = 0; k < PROCESS_OUTPUTS_MAX; k++) x->format[k] = MEDIA_COUNT;
  if (!read_object(t, body, NULL)) return;
  read_required(t, &x->inputs);
  read_qualifiers(t, &x->inputs);
  if (read_object(t, &x->inputs, p->inputs)) read_outputs(t, p, &outputs, x);
  read_choice(t, &response, responses, &chosen);
  read_subscriber(t, &subscriber, x);
  x->is_raw = chosen == 1;
}
