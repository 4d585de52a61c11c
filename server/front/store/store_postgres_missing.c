/* In place of store_postgres*.c where libpq was not there when this was built. */
#include "store_sql.h"

static bool open_base(store *s, const char *where, fault *why) {
  (void)s, (void)where;
  return fault_set(why, "store: this scatterd was built without libpq (Debian: libpq-dev)");
}

static void close_base(store *s) {
  (void)s;
}

const store_door store_postgres = {
    .dialect = DIALECT_POSTGRES, .shared = true, .open = open_base, .close = close_base};
