#include "parameters_input.h"

#include "expression.h"

static bool name_is_free(task *t, const item *it) {
  char room[SHOWN_MAX];
  if (!expression_is_name(it->key)) {
    complain(
        t, it,
        "\"%s\" is no name, needs a letter and then letters, digits or underscores, %d at most",
        shown(it->key, room), EXPRESSION_NAME - 1);
    return false;
  }
  if (!expression_is_reserved(it->key)) return true;
  complain(t, it, "\"%s\" is a name that expressions have already, needs another", it->key);
  return false;
}

bool parameters_input_read(task *t, const item *it) {
  if (!it->doc) return true;
  if (!read_object(t, it, NULL)) return false;
  bool good = true;
  for (const doc *m = it->doc->child; m; m = m->next) {
    item member = {.doc = m, .up = it, .key = m->key};
    double value;
    good &= name_is_free(t, &member);
    good &= read_number(t, &member, &range_any, &value);
  }
  t->parameters = it->doc;
  return good;
}
