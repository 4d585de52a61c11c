#include "counter.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char counter_media[] = "text/plain; version=0.0.4; charset=utf-8";

typedef enum { COUNT, GAUGE, HISTOGRAM } kind;
static const char *const kind_names[] = {"counter", "gauge", "histogram"};

/* Upper ends of the buckets (s): from a health check to the longest solve. */
static const double buckets[] = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5,
                                 1,     2.5,    5,     10,   30,    60,   300, 1800};
enum { BUCKETS = sizeof buckets / sizeof *buckets };

typedef struct {
  char *label[COUNTER_LABELS];  /* NULL beyond those of the metric */
  double value;                 /* or sum */
  uint64_t within[BUCKETS + 1]; /* observations by bucket, those beyond the last one last */
} series;

typedef struct {
  kind kind;
  const char *name, *labels, *help;
  series *all;
  int count;
} metric;

#define ROW(symbol, kind, name, labels, help) {kind, name, labels, help, NULL, 0},
static metric metrics[] = {COUNTER_LIST(ROW)};
#undef ROW

/* ---- Series ---- */

static bool same(const char *a, const char *b) {
  return a == b || (a != NULL && b != NULL && strcmp(a, b) == 0);
}

static bool is_series(const series *s, const counter_labels *labels) {
  for (int k = 0; k < COUNTER_LABELS; k++) {
    if (!same(s->label[k], labels->value[k])) return false;
  }
  return true;
}

static series *find(const metric *m, const counter_labels *labels) {
  for (int k = 0; k < m->count; k++) {
    if (is_series(&m->all[k], labels)) return &m->all[k];
  }
  return NULL;
}

static void clear(series *s) {
  for (int k = 0; k < COUNTER_LABELS; k++) free(s->label[k]);
}

/* NULL when out of memory. */
static series *append(metric *m, const counter_labels *labels) {
  series *all = realloc(m->all, (size_t)(m->count + 1) * sizeof *all);
  if (all == NULL) return NULL;
  m->all = all;
  series *s = &all[m->count];
  *s = (series){.value = 0};
  for (int k = 0; k < COUNTER_LABELS; k++) {
    if (labels->value[k] == NULL) continue;
    s->label[k] = strdup(labels->value[k]);
    if (s->label[k] != NULL) continue;
    clear(s);
    return NULL;
  }
  m->count++;
  return s;
}

static series *series_of(counter c, counter_labels labels) {
  metric *m = &metrics[c];
  series *s = find(m, &labels);
  if (s != NULL) return s;
  for (int k = 0; m->count >= COUNTER_SERIES_MAX - 1 && k < COUNTER_LABELS; k++) {
    if (labels.value[k] != NULL) labels.value[k] = "other";
  }
  s = find(m, &labels);
  return s != NULL ? s : append(m, &labels);
}

/* ---- Counting ---- */

void counter_add(counter c, double by, counter_labels labels) {
  series *s = series_of(c, labels);
  if (s != NULL && by > 0) s->value += by;
}

void counter_set(counter c, double value, counter_labels labels) {
  series *s = series_of(c, labels);
  if (s != NULL) s->value = value;
}

void counter_observe(counter c, double seconds, counter_labels labels) {
  series *s = series_of(c, labels);
  int b = 0;
  if (s == NULL) return;
  while (b < BUCKETS && !(seconds <= buckets[b])) b++;
  s->within[b]++;
  s->value += seconds;
}

void counter_reset(void) {
  for (int c = 0; c < COUNTER_COUNT; c++) {
    for (int k = 0; k < metrics[c].count; k++) clear(&metrics[c].all[k]);
    free(metrics[c].all);
    metrics[c].all = NULL;
    metrics[c].count = 0;
  }
}

/* ---- Text ---- */

static void write_value(FILE *out, double value) {
  if (isfinite(value)) fprintf(out, " %.17g\n", value);
  if (isnan(value)) fputs(" NaN\n", out);
  if (isinf(value)) fputs(value > 0 ? " +Inf\n" : " -Inf\n", out);
}

/* The value of a label: backslash, quote and line feed escaped. */
static void write_escaped(FILE *out, const char *text) {
  for (; *text != '\0'; text++) {
    if (*text == '\\' || *text == '"') fputc('\\', out);
    if (*text == '\n') fputs("\\n", out);
    if (*text != '\n') fputc(*text, out);
  }
}

/* name{label="value",le="..."}; `le` NULL: none. */
static void write_name(FILE *out, const metric *m, const char *suffix, const series *s,
                       const char *le) {
  const char *name = m->labels;
  char before = '{';
  fprintf(out, "%s%s", m->name, suffix);
  for (int k = 0; k < COUNTER_LABELS && *name != '\0'; k++) {
    const int length = (int)strcspn(name, " ");
    fprintf(out, "%c%.*s=\"", before, length, name);
    write_escaped(out, s->label[k] != NULL ? s->label[k] : "");
    fputc('"', out);
    before = ',';
    name += length + (name[length] != '\0');
  }
  if (le != NULL) fprintf(out, "%cle=\"%s\"", before, le);
  if (le != NULL || before == ',') fputc('}', out);
}

static void write_histogram(FILE *out, const metric *m, const series *s) {
  uint64_t below = 0;
  for (int b = 0; b <= BUCKETS; b++) {
    char le[32] = "+Inf";
    if (b < BUCKETS) snprintf(le, sizeof le, "%g", buckets[b]);
    below += s->within[b];
    write_name(out, m, "_bucket", s, le);
    fprintf(out, " %llu\n", (unsigned long long)below);
  }
  write_name(out, m, "_sum", s, NULL);
  write_value(out, s->value);
  write_name(out, m, "_count", s, NULL);
  fprintf(out, " %llu\n", (unsigned long long)below);
}

static void write_metric(FILE *out, const metric *m) {
  fprintf(out, "# HELP %s %s\n# TYPE %s %s\n", m->name, m->help, m->name, kind_names[m->kind]);
  for (int k = 0; k < m->count; k++) {
    if (m->kind == HISTOGRAM) {
      write_histogram(out, m, &m->all[k]);
      continue;
    }
    write_name(out, m, "", &m->all[k], NULL);
    write_value(out, m->all[k].value);
  }
}

char *counter_text(size_t *size) {
  char *text = NULL;
  FILE *out = open_memstream(&text, size);
  if (out == NULL) return NULL;
  for (int c = 0; c < COUNTER_COUNT; c++) write_metric(out, &metrics[c]);
  if (fclose(out) == 0) return text;
  free(text);
  return NULL;
}

/* ---- Page ---- */

void counter_reference(FILE *out) {
  fputs(
      "# Metrics of scatterd\n\n"
      "`GET /metrics` tells them in the text format of Prometheus. Counters start at 0 with the\n"
      "daemon; sizes are in bytes, times in seconds.\n\n"
      "| metric | kind | labels | meaning |\n|---|---|---|---|\n",
      out);
  for (int c = 0; c < COUNTER_COUNT; c++) {
    const metric *m = &metrics[c];
    fprintf(out, "| %s | %s | %s | %s |\n", m->name, kind_names[m->kind], m->labels, m->help);
  }
}
