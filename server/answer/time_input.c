#include "time_input.h"

#include <string.h>

#define NAME(symbol, name) name,
static const char *const methods[] = {SCT_MARCH_LIST(NAME) NULL};
#undef NAME

static bool times_ascend(task *t, const item *it, const sct_march_options *march) {
  bool good = true;
  for (int64_t k = 0; k < march->saves; k++) {
    double least = k ? march->save[k - 1] : march->start, time = march->save[k];
    if (time >= least && time <= march->end && (k == 0 || time > least)) continue;
    item entry = item_element(it, NULL, k);
    complain(t, &entry, "is %.15g, needs a time from start to end above those before it", time);
    good = false;
  }
  return good;
}

static bool read_interval(task *t, const item *it, sct_march_options *march) {
  item start = item_member(it, "start"), end = item_member(it, "end");
  item save = item_member(it, "save");
  numbers saves = {0};
  bool good = read_number(t, &start, &range_any, &march->start);
  good &= read_required(t, &end) && read_number(t, &end, &range_any, &march->end);
  good &= read_numbers(t, &save, 1, &saves);
  march->save = saves.data;
  march->saves = saves.rows;
  if (!good) return false;
  if (march->end > march->start) return times_ascend(t, &save, march);
  complain(t, &end, "is %.15g, needs a time after start, %.15g", march->end, march->start);
  return false;
}

static bool read_step(task *t, const item *it, sct_march_options *march) {
  item step = item_member(it, "step"), number = item_member(it, "diffusion_number");
  march->diffusion_number = 1;
  bool good = read_number(t, &step, &range_positive, &march->step);
  good &= read_number(t, &number, &range_positive, &march->diffusion_number);
  if (!good || !step.doc || !number.doc) return good;
  complain(t, &number, "stands beside step, needs to be left out: one of the two sets the step");
  return false;
}

bool time_input_read(task *t, const item *it, sct_march_options *march) {
  static const char *const members[] = {"method",           "start", "end", "step", "save",
                                        "diffusion_number", NULL};
  item method = item_member(it, "method");
  int chosen = SCT_CRANK_NICOLSON;
  *march = (sct_march_options){0};
  if (!it->doc) return true;
  bool good = read_object(t, it, members);
  if (it->doc->kind != DOC_OBJECT) return false;
  good &= read_choice(t, &method, methods, &chosen);
  good &= read_interval(t, it, march);
  good &= read_step(t, it, march);
  march->method = (sct_march_method)chosen;
  march->max_steps = t->limits->steps;
  return good;
}

/* A method that this daemon was built without, or that is not installed. */
static bool method_is_there(task *t, const item *method, const char *name) {
  sct_error why;
  if (strcmp(name, "iterative") != 0) return true;
  if (sct_solver_load_iterative(&why) != SCT_E_ARGUMENT) return true;
  complain(t, method, "is \"iterative\": %s", why.text);
  return false;
}

bool solver_input_read(task *t, const item *it, sct_march_options *march) {
  enum { NAMES_MAX = 16 };
  static const char *const members[] = {"method", "tolerance", "max_iterations", "preconditioner",
                                        NULL};
  static const char *const preconditioners[] = {"auto", "ilu", "amg", NULL};
  static const range tolerances = {0, 1, true, false};
  const char *names[NAMES_MAX + 1] = {"auto", "direct"};
  item method = item_member(it, "method"), tolerance = item_member(it, "tolerance");
  item iterations = item_member(it, "max_iterations");
  item preconditioner = item_member(it, "preconditioner");
  sct_solve_options *solve = &march->solve;
  int conditioned = 0;
  int64_t count = 0;
  int chosen = 0;
  for (int k = 0; k + 2 < NAMES_MAX && sct_solver_name(k); k++) names[k + 2] = sct_solver_name(k);
  bool good = read_object(t, it, members);
  if (it->doc && it->doc->kind != DOC_OBJECT) return false;
  good &= read_choice(t, &method, names, &chosen) && method_is_there(t, &method, names[chosen]);
  good &= read_number(t, &tolerance, &tolerances, &solve->tolerance);
  good &= read_integer(t, &iterations, 1, INT32_MAX, &count);
  good &= read_choice(t, &preconditioner, preconditioners, &conditioned);
  solve->method = names[chosen];
  solve->preconditioner = conditioned ? preconditioners[conditioned] : NULL;
  solve->max_iterations = count;
  march->limited = (sct_limited_options){solve->tolerance, count};
  return good;
}
