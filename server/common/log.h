/* log.h - the log: one line of key=value pairs (logfmt) per event, to standard error.
 *
 * Values with blanks, quotes or control characters are quoted and escaped, so that no client can
 * forge a line. Who reads it and stands still is waited for once, 5 s; what then has no room is
 * lost, and counted in a line of its own as soon as there is some. Test: unit.log.
 */
#ifndef SCATTERD_LOG_H
#define SCATTERD_LOG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum { LOG_ERROR, LOG_INFO, LOG_DEBUG } log_level;

const char *log_level_name(log_level level);
int log_level_of(const char *name); /* -1 for no level */

/* What is less urgent than `level` is left out. LOG_INFO at first. */
void log_limit(log_level level);

/* A line being built: log_begin, any number of pairs, log_end writes it in one piece. Pairs that do
 * not fit are dropped. */
typedef struct {
  bool wanted;
  size_t used;
  char text[2048];
} log_line;

void log_begin(log_line *line, log_level level, const char *event);
void log_text(log_line *line, const char *key, const char *value); /* nothing for NULL */
void log_count(log_line *line, const char *key, int64_t value);
void log_milliseconds(log_line *line, const char *key, double seconds);
void log_end(log_line *line);

/* A line in one call: event and a message. */
void log_say(log_level level, const char *event, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
