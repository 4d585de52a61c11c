#include "doc_show.h"

#include <inttypes.h>
#include <stdlib.h>

static void show(FILE *to, const doc *d);

static void show_text(FILE *to, const char *text, size_t length) {
  fputc('"', to);
  for (size_t k = 0; k < length; k++) {
    if (text[k] == '\0') {
      fputs("\\0", to);
    } else {
      fputc(text[k], to);
    }
  }
  fputc('"', to);
}

static void show_numbers(FILE *to, const doc *d) {
  fputc('<', to);
  for (int k = 0; k < d->rank; k++) fprintf(to, "%s%" PRId64, k ? "x" : "", d->shape[k]);
  fputc(':', to);
  for (int64_t k = 0; k < d->count; k++) fprintf(to, " %.17g", d->data[k]);
  fputc('>', to);
}

static void show_children(FILE *to, const doc *d, const char *brackets) {
  int64_t count = 0;
  fputc(brackets[0], to);
  for (const doc *c = d->child; c != NULL; c = c->next, count++) {
    if (c != d->child) fputs(", ", to);
    if (c->key != NULL) fprintf(to, "\"%s\": ", c->key);
    show(to, c);
  }
  fputc(brackets[1], to);
  if (count != d->count) fprintf(to, "(count is %" PRId64 "!)", d->count);
}

static void show(FILE *to, const doc *d) {
  switch (d->kind) {
    case DOC_NULL:
      fputs("null", to);
      break;
    case DOC_BOOL:
      fputs(d->truth ? "true" : "false", to);
      break;
    case DOC_NUMBER:
      fprintf(to, "%.17g", d->number);
      break;
    case DOC_TEXT:
      show_text(to, d->text, d->length);
      break;
    case DOC_LIST:
      show_children(to, d, "[]");
      break;
    case DOC_OBJECT:
      show_children(to, d, "{}");
      break;
    case DOC_NUMBERS:
      show_numbers(to, d);
      break;
  }
}

char *doc_show(const doc *d) {
  char *text = NULL;
  size_t size = 0;
  FILE *to = open_memstream(&text, &size);
  show(to, d);
  fclose(to);
  return text;
}
