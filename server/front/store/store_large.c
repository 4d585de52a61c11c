/* Bytes of jobs and of data within the database, in pieces: for a store that several daemons share,
 * so that they need no file system in common. */
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include "memory_file.h"
#include "store_sql.h"

enum { PIECE = 1 << 20 };

store_result store_add_large(store *s, const char *owner, int which, int fd, size_t size) {
  char *piece = malloc(PIECE);
  store_result result = store_drop_large(s, owner, which, which);
  if (piece == NULL) result = STORE_DOWN;
  for (size_t at = 0, k = 0; at < size && result == STORE_OK; k++) {
    const size_t length = size - at < PIECE ? size - at : PIECE;
    if (pread(fd, piece, length, (off_t)at) != (ssize_t)length) {
      result = STORE_FAILED;
      break;
    }
    sql_text(s, ADD_LARGE, ":owner", owner);
    sql_long(s, ADD_LARGE, ":kind", which);
    sql_long(s, ADD_LARGE, ":chunk", (int64_t)k);
    sql_blob(s, ADD_LARGE, ":bytes", piece, length);
    result = sql_run(s, ADD_LARGE);
    at += length;
  }
  free(piece);
  return result;
}

/* A nameless file where large bodies go, too; in memory if there is none to be had. */
static int nameless(const store *s) {
  int file = openat(s->directory, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file < 0) file = memory_file("large");
  return file;
}

/* Appends piece k: STORE_NONE after the last. */
static store_result copy_piece(store *s, const char *owner, int which, int64_t k, int to) {
  sql_text(s, LARGE, ":owner", owner);
  sql_long(s, LARGE, ":kind", which);
  sql_long(s, LARGE, ":chunk", k);
  store_result result = sql_step(s, LARGE);
  if (result == STORE_OK) {
    size_t size = 0;
    const void *bytes = s->door->get_bytes(s, LARGE, 0, &size);
    if (write(to, bytes, size) != (ssize_t)size) result = STORE_FULL;
  }
  sql_reset(s, LARGE);
  return result;
}

int store_open_large(store *s, const char *owner, int which) {
  int to = nameless(s);
  if (to < 0) return -1;
  store_result result = STORE_OK;
  int64_t k = 0;
  while ((result = copy_piece(s, owner, which, k, to)) == STORE_OK) k++;
  int reason = store_errno(result);
  if (result == STORE_NONE && k > 0) {
    if (file_reopen(&to)) return to;
    reason = errno;
  }
  close(to);
  errno = reason;
  return -1;
}

store_result store_drop_large(store *s, const char *owner, int least, int most) {
  sql_text(s, DROP_LARGE, ":owner", owner);
  sql_long(s, DROP_LARGE, ":least", least);
  sql_long(s, DROP_LARGE, ":most", most);
  return sql_run(s, DROP_LARGE);
}
