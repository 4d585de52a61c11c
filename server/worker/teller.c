#include "teller.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

double teller_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

bool teller_takes(teller *t, const char *phase, double fraction, ipc_news *news) {
  *news = (ipc_news){
      .kind = IPC_PROGRESS, .time = teller_now(), .fraction = fraction, .residual = t->residual};
  snprintf(news->phase, sizeof news->phase, "%s", phase);
  const bool is_new = strcmp(news->phase, t->phase) != 0;
  if (!is_new && news->time - t->last < t->pause) return false;
  t->last = news->time;
  t->residual = 0;
  memcpy(t->phase, news->phase, sizeof t->phase);
  return true;
}
