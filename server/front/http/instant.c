#include "instant.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double day = 86400;

/* `count` digits at *at as a number from least to most; -1 if they are none. */
static int digits(const char **at, int count, int least, int most) {
  int value = 0;
  for (int k = 0; k < count; k++, ++*at) {
    if (!isdigit((unsigned char)**at)) return -1;
    value = 10 * value + (**at - '0');
  }
  return value >= least && value <= most ? value : -1;
}

static bool one(const char **at, char c) {
  return *(*at)++ == c;
}

static int days_of(int year, int month) {
  static const int days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
  return days[month] + (month == 1 && is_leap);
}

static bool read_date(const char **at, struct tm *t) {
  t->tm_year = digits(at, 4, 0, 9999) - 1900;
  if (t->tm_year < -1900 || !one(at, '-')) return false;
  t->tm_mon = digits(at, 2, 1, 12) - 1;
  if (t->tm_mon < 0 || !one(at, '-')) return false;
  t->tm_mday = digits(at, 2, 1, days_of(t->tm_year + 1900, t->tm_mon));
  return t->tm_mday > 0;
}

static bool read_clock(const char **at, struct tm *t) {
  t->tm_hour = digits(at, 2, 0, 23);
  if (t->tm_hour < 0 || !one(at, ':')) return false;
  t->tm_min = digits(at, 2, 0, 59);
  if (t->tm_min < 0 || !one(at, ':')) return false;
  t->tm_sec = digits(at, 2, 0, 60);
  return t->tm_sec >= 0;
}

/* Fraction of a second, NaN for a point alone; *step becomes what its last digit is worth. */
static double read_fraction(const char **at, double *step) {
  double value = 0;
  *step = 1;
  if (**at != '.') return 0;
  if (!isdigit((unsigned char)(*at)[1])) return NAN;
  for (++*at; isdigit((unsigned char)**at); ++*at) {
    *step /= 10;
    value += *step * (**at - '0');
  }
  return value;
}

/* Z or +hh:mm, in seconds east; NaN for anything else. */
static double read_zone(const char **at) {
  const char sign = *(*at)++;
  if (sign == 'Z' || sign == 'z') return 0;
  if (sign != '+' && sign != '-') return NAN;
  const int hours = digits(at, 2, 0, 23);
  if (hours < 0 || !one(at, ':')) return NAN;
  const int minutes = digits(at, 2, 0, 59);
  return minutes < 0 ? NAN : (sign == '-' ? -60 : 60) * (60.0 * hours + minutes);
}

bool instant_read(const char *text, int length, double *first, double *last) {
  char copy[64];
  struct tm t = {0};
  const char *at = copy;
  if (length >= (int)sizeof copy) return false;
  snprintf(copy, sizeof copy, "%.*s", length, text);
  if (!read_date(&at, &t)) return false;
  if (*at == '\0') {
    *first = (double)timegm(&t);
    *last = *first + day;
    return true;
  }
  if (*at != 'T' && *at != 't' && *at != ' ') return false;
  at++;
  if (!read_clock(&at, &t)) return false;
  double step;
  const double fraction = read_fraction(&at, &step), zone = read_zone(&at);
  *first = (double)timegm(&t) + fraction - zone;
  *last = *first + step;
  return !isnan(fraction) && !isnan(zone) && *at == '\0';
}

static bool is_open(const char *text, int length) {
  return length == 0 || (length == 2 && strncmp(text, "..", 2) == 0);
}

bool instant_interval(const char *text, double *first, double *last) {
  double ignored;
  const char *slash = strchr(text, '/');
  if (slash == NULL) return instant_read(text, (int)strlen(text), first, last);
  const int before = (int)(slash - text), after = (int)strlen(slash + 1);
  *first = -INFINITY;
  *last = INFINITY;
  if (is_open(text, before) && is_open(slash + 1, after)) return before + after > 0;
  if (!is_open(text, before) && !instant_read(text, before, first, &ignored)) return false;
  if (!is_open(slash + 1, after) && !instant_read(slash + 1, after, &ignored, last)) return false;
  return *first <= *last;
}
