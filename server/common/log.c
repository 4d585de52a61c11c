#include "log.h"

#include <poll.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char *const names[] = {
    [LOG_ERROR] = "error", [LOG_INFO] = "info", [LOG_DEBUG] = "debug"};

static log_level limit = LOG_INFO;

const char *log_level_name(log_level level) {
  return names[level];
}

int log_level_of(const char *name) {
  for (int k = 0; k <= LOG_DEBUG; k++) {
    if (strcmp(names[k], name) == 0) return k;
  }
  return -1;
}

void log_limit(log_level level) {
  limit = level;
}

/* Room that must stay for the newline. */
static size_t room(const log_line *line) {
  return sizeof line->text - 1 - line->used;
}

static void add(log_line *line, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add(log_line *line, const char *format, ...) {
  if (!line->wanted) return;
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(line->text + line->used, room(line), format, arguments);
  va_end(arguments);
  if (length >= 0 && (size_t)length < room(line)) line->used += (size_t)length;
}

/* UTC with milliseconds, RFC 3339. */
static void add_time(log_line *line) {
  struct timespec now;
  struct tm utc;
  char date[32];
  clock_gettime(CLOCK_REALTIME, &now);
  gmtime_r(&now.tv_sec, &utc);
  strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &utc);
  add(line, "time=%s.%03ldZ", date, now.tv_nsec / 1000000);
}

void log_begin(log_line *line, log_level level, const char *event) {
  line->wanted = level <= limit;
  line->used = 0;
  if (!line->wanted) return;
  add_time(line);
  add(line, " level=%s event=%s", names[level], event);
}

static bool is_plain(const char *value) {
  for (const char *at = value; *at != '\0'; at++) {
    if (*at <= ' ' || *at > '~' || strchr("\"=\\", *at) != NULL) return false;
  }
  return *value != '\0';
}

/* Writes one character of a quoted value; bytes above ASCII are escaped too, so that the log is
 * text whatever a client sends. Returns its length. */
static size_t put_escaped(char c, char *to) {
  const unsigned char byte = (unsigned char)c;
  if (c == '"' || c == '\\') {
    to[0] = '\\';
    to[1] = c;
    return 2;
  }
  if (byte >= ' ' && byte < 127) {
    to[0] = c;
    return 1;
  }
  return (size_t)snprintf(to, 5, "\\x%02x", byte);
}

static void add_quoted(log_line *line, const char *key, const char *value) {
  char quoted[1024];
  size_t used = 0;
  for (const char *at = value; *at != '\0' && used < sizeof quoted - 8; at++) {
    used += put_escaped(*at, quoted + used);
  }
  quoted[used] = '\0';
  add(line, " %s=\"%s\"", key, quoted);
}

void log_text(log_line *line, const char *key, const char *value) {
  if (!line->wanted || value == NULL) return;
  if (is_plain(value) && strlen(value) < 1024) {
    add(line, " %s=%s", key, value);
  } else {
    add_quoted(line, key, value);
  }
}

void log_count(log_line *line, const char *key, int64_t value) {
  add(line, " %s=%lld", key, (long long)value);
}

void log_milliseconds(log_line *line, const char *key, double seconds) {
  add(line, " %s=%.3f", key, 1e3 * seconds);
}

/* ---- Writing ---- */

static const int patience = 5000; /* (ms) with who reads it and stands still */
static atomic_llong lost;         /* lines since then */

/* Is there room for a line? That is waited for once; then lines are lost until there is. */
static bool is_read(void) {
  struct pollfd reader = {.fd = STDERR_FILENO, .events = POLLOUT};
  return poll(&reader, 1, lost == 0 ? patience : 0) != 0;
}

static void write_line(log_line *line) {
  line->text[line->used++] = '\n';
  const ssize_t written = write(STDERR_FILENO, line->text, line->used);
  (void)written; /* a log that cannot be written is no reason to stop */
}

static void tell_lost(void) {
  log_line line;
  const long long count = atomic_exchange(&lost, 0);
  if (count == 0) return;
  log_begin(&line, LOG_ERROR, "log");
  log_count(&line, "lost", count);
  write_line(&line);
}

void log_end(log_line *line) {
  if (!line->wanted) return;
  if (is_read()) {
    tell_lost();
    write_line(line);
  } else {
    lost++;
  }
}

void log_say(log_level level, const char *event, const char *format, ...) {
  if (level > limit) return;
  char message[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  log_line line;
  log_begin(&line, level, event);
  log_text(&line, "message", message);
  log_end(&line);
}
