/* Any text as each header field and query value that the front reads: no step beyond its end, and
 * what is read stays within its bounds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "exchange.h"
#include "fuzz.h"
#include "instant.h"
#include "media.h"
#include "prefer.h"
#include "range.h"

enum { LONGEST = 2000 };

static void require(int holds, const char *what, const char *text) {
  if (holds) return;
  fprintf(stderr, "does not hold: %s: %s\n", what, text);
  abort();
}

static void read_prefer(const char *text) {
  const prefer p = prefer_of(text, 60);
  require(p.wait == -1 || (p.wait >= 0 && p.wait <= 60), "Prefer: wait", text);
  require(p.priority >= -1 && p.priority <= 9, "Prefer: priority", text);
  require(p.shape <= PREFER_REPRESENTATION, "Prefer: return", text);
}

static void read_range(const char *text) {
  static const size_t sizes[] = {0, 1, 100, SIZE_MAX};
  for (int k = 0; k < 4; k++) {
    size_t first = 0, length = 0;
    if (range_of(text, sizes[k], &first, &length) != RANGE_PART) continue;
    require(length > 0 && first < sizes[k] && length <= sizes[k] - first, "Range", text);
  }
}

static void read_accept(const char *text) {
  static const media offers[] = {MEDIA_JSON, MEDIA_CBOR, MEDIA_NPY, MEDIA_VTP, MEDIA_MULTIPART};
  static const char *const types[] = {"application/json", "text/html", "application/x-npy"};
  const wishes w = media_wishes(text);
  for (int m = 0; m < MEDIA_COUNT; m++) require(w.of[m] <= 1000, "Accept: q", text);
  const media picked = media_pick(&w, offers, 5);
  require(picked == MEDIA_COUNT || !w.stated || w.of[picked] > 0, "Accept: what is wanted", text);
  const int chosen = media_choose(text, types, 3);
  require(chosen < 0 || media_quality(text, types[chosen]) > 0, "Accept: what is wanted", text);
  (void)media_names(text, "application/json");
}

static void read_coding(const char *text) {
  coding c = CODING_COUNT;
  if (coding_choose(text, &c)) require(c < CODING_COUNT, "Accept-Encoding", text);
  require(c == CODING_IDENTITY || coding_accepts(text, c) || strchr(text, '*') != NULL,
          "Accept-Encoding: by name", text);
  if (coding_of_body(text, &c)) require(c < CODING_COUNT, "Content-Encoding", text);
}

static void read_content(const char *text) {
  media m = MEDIA_COUNT;
  if (media_of_body(text, &m)) require(m <= MEDIA_CSV, "Content-Type", text);
  if (media_find(text, &m)) require(m < MEDIA_COUNT, "media type", text);
}

static void read_instant(const char *text) {
  double first, last;
  if (instant_interval(text, &first, &last)) require(first <= last, "datetime", text);
}

/* As a request target, a Host and an X-Request-Id. */
static void read_target(const char *text) {
  exchange *x = exchange_new(text);
  if (x == NULL) return;
  if (exchange_find_path(x)) require(strlen(x->path) <= strlen(text) + 1, "path", text);
  if (exchange_is_host(text)) require(strpbrk(text, "/?#@ \r\n\"<>") == NULL, "Host", text);
  exchange_identify(x, text);
  require(x->id[0] != '\0' && strpbrk(x->id, " \r\n\"=") == NULL, "X-Request-Id", text);
  exchange_free(&x);
}

static void (*const readers[])(const char *) = {
    read_prefer, read_range, read_accept, read_coding, read_content, read_instant, read_target};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size > LONGEST) return 0;
  char *text = malloc(size + 1); /* exactly sized: a sanitizer sees any step beyond */
  memcpy(text, data, size);
  text[size] = '\0';
  char *exact = strdup(text);
  for (size_t k = 0; k < sizeof readers / sizeof *readers; k++) readers[k](exact);
  free(exact);
  free(text);
  return 0;
}
