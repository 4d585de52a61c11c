#include "ready.h"

#include <unistd.h>

#include "spool.h"

static bool has_workers(const service *s) {
  return pool_ready(s->pool) > 0;
}

static bool has_room(const service *s) {
  return pool_waiting(s->pool) < s->set->queue || s->set->queue == 0;
}

static bool has_room_for_jobs(const service *s) {
  return jobs_room(s->jobs) > 0;
}

/* Writes a byte to where large bodies go, as they do. */
static bool can_write(const service *s) {
  spool probe = SPOOL_EMPTY;
  const bool good = spool_add(&probe, "", 1, 0, s->set->data_dir);
  spool_close(&probe);
  return good;
}

static bool has_database(const service *s) {
  return store_is_up(s->store);
}

static const struct {
  const char *name, *reason;
  bool (*holds)(const service *s);
} checks[] = {
    {"workers", "no worker is up", has_workers},
    {"queue", "the queue is full", has_room},
    {"jobs", "the queue of jobs is full", has_room_for_jobs},
    {"store", "the data directory cannot be written", can_write},
    {"database", "the database does not answer", has_database},
};
enum { CHECKS = sizeof checks / sizeof *checks };

bool ready_check(const service *s, int k, const char **name, const char **reason) {
  *name = k < CHECKS ? checks[k].name : NULL;
  *reason = k < CHECKS ? checks[k].reason : NULL;
  return k >= CHECKS || checks[k].holds(s);
}
