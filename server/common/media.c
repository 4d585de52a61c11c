#include "media.h"

#include <math.h>
#include <stddef.h>
#include <string.h>
#include <strings.h>

#include "field.h"

static const char *const types[MEDIA_COUNT] = {
    [MEDIA_JSON] = "application/json",
    [MEDIA_CBOR] = "application/cbor",
    [MEDIA_PROBLEM] = "application/problem+json",
    [MEDIA_NPY] = "application/x-npy",
    [MEDIA_VTP] = "application/vnd.vtk.vtp+xml",
    [MEDIA_CSV] = "text/csv",
    [MEDIA_MULTIPART] = "multipart/related",
    [MEDIA_NDJSON] = "application/x-ndjson",
    [MEDIA_OCTETS] = "application/octet-stream",
};

/* What some are also called. */
static const struct {
  const char *type;
  media media;
} others[] = {{"model/vnd.vtk", MEDIA_VTP}, {"application/ndjson", MEDIA_NDJSON}};
enum { OTHERS = sizeof others / sizeof *others };

static const char *const codings[CODING_COUNT] = {
    [CODING_IDENTITY] = "identity",
    [CODING_GZIP] = "gzip",
    [CODING_ZSTD] = "zstd",
};

const char *media_type(media m) {
  return types[m];
}

const char *coding_name(coding c) {
  return codings[c];
}

/* How specific a media range is for `type`: 3 the type itself, 2 "type/ *", 1 "* / *", 0 not it.
 */
static int specific(span range, const char *type) {
  const size_t main = strcspn(type, "/");
  const size_t bare = strcspn(type, ";");
  if (range.length == bare && strncasecmp(range.at, type, bare) == 0) return 3;
  if (range.length == main + 2 && strncasecmp(range.at, type, main + 1) == 0 &&
      range.at[main + 1] == '*') {
    return 2;
  }
  return span_is(range, "*/*") || span_is(range, "*") ? 1 : 0;
}

static bool is_blank(const char *accept) {
  return accept == NULL || accept[strspn(accept, " \t,")] == '\0';
}

double media_quality(const char *accept, const char *type) {
  if (is_blank(accept)) return 1;
  int best = 0;
  double quality = 0;
  field_item item;
  for (const char *rest = accept; field_next(&rest, &item);) {
    const int rank = specific(item.name, type);
    if (rank <= best) continue;
    best = rank;
    quality = field_quality(&item);
  }
  return quality;
}

int media_choose(const char *accept, const char *const *offers, int count) {
  int chosen = -1;
  double most = 0;
  for (int k = 0; k < count; k++) {
    const double quality = media_quality(accept, offers[k]);
    if (quality <= most) continue;
    most = quality;
    chosen = k;
  }
  return chosen;
}

static int thousandths(const char *accept, media m) {
  double quality = media_quality(accept, types[m]);
  for (int k = 0; k < OTHERS; k++) {
    if (others[k].media == m) quality = fmax(quality, media_quality(accept, others[k].type));
  }
  return (int)ceil(1000 * quality);
}

wishes media_wishes(const char *accept) {
  wishes w = {0};
  if (is_blank(accept)) return w;
  w.stated = true;
  for (int m = 0; m < MEDIA_COUNT; m++) w.of[m] = (uint16_t)thousandths(accept, (media)m);
  return w;
}

wishes media_wish(media only) {
  wishes w = {.stated = true};
  w.of[only] = 1000;
  return w;
}

media media_pick(const wishes *w, const media *offers, int count) {
  media picked = MEDIA_COUNT;
  int most = 0;
  if (!w->stated) return count > 0 ? offers[0] : MEDIA_COUNT;
  for (int k = 0; k < count; k++) {
    if (w->of[offers[k]] <= most) continue;
    most = w->of[offers[k]];
    picked = offers[k];
  }
  return picked;
}

bool media_names(const char *accept, const char *type) {
  field_item item;
  for (const char *rest = accept != NULL ? accept : ""; field_next(&rest, &item);) {
    if (span_is(item.name, type)) return field_quality(&item) > 0;
  }
  return false;
}

static bool media_of_name(span name, media *out) {
  for (int m = 0; m < MEDIA_COUNT; m++) {
    *out = (media)m;
    if (span_is(name, types[m])) return true;
  }
  for (int k = 0; k < OTHERS; k++) {
    *out = others[k].media;
    if (span_is(name, others[k].type)) return true;
  }
  return false;
}

bool media_find(const char *type, media *out) {
  field_item item;
  return field_next(&type, &item) && media_of_name(item.name, out);
}

/* What a body may be. */
static const bool is_body[MEDIA_COUNT] = {
    [MEDIA_JSON] = true, [MEDIA_CBOR] = true, [MEDIA_NPY] = true, [MEDIA_CSV] = true};

bool media_of_body(const char *content_type, media *out) {
  *out = MEDIA_JSON;
  if (content_type == NULL) return true;
  field_item item;
  const char *rest = content_type;
  if (!field_next(&rest, &item) || *rest != '\0') return false;
  span charset;
  if (field_parameter(&item, "charset", &charset) && !span_is(charset, "utf-8")) return false;
  return media_of_name(item.name, out) && is_body[*out];
}

/* Row of a coding's name, -1 if unknown; x-gzip is an old name of gzip (RFC 9110, 8.4.1.3). */
static int coding_row(span name) {
  if (span_is(name, "x-gzip")) return CODING_GZIP;
  for (int c = 0; c < CODING_COUNT; c++) {
    if (span_is(name, codings[c])) return c;
  }
  return -1;
}

bool coding_of_body(const char *content_encoding, coding *out) {
  *out = CODING_IDENTITY;
  field_item item;
  for (const char *rest = content_encoding != NULL ? content_encoding : "";
       field_next(&rest, &item);) {
    const int row = coding_row(item.name);
    if (row < 0 || (*out != CODING_IDENTITY && row != CODING_IDENTITY)) return false;
    if (row != CODING_IDENTITY) *out = (coding)row;
  }
  return true;
}

/* What the field says of each coding, and of "*"; what it does not name stays as it is. */
static void read_qualities(const char *accept_encoding, double quality[CODING_COUNT],
                           double *star) {
  field_item item;
  for (const char *rest = accept_encoding != NULL ? accept_encoding : "";
       field_next(&rest, &item);) {
    const int row = coding_row(item.name);
    if (row >= 0) quality[row] = field_quality(&item);
    if (span_is(item.name, "*")) *star = field_quality(&item);
  }
}

bool coding_accepts(const char *accept_encoding, coding c) {
  double quality[CODING_COUNT] = {0}, star = 0;
  read_qualities(accept_encoding, quality, &star);
  return quality[c] > 0;
}

bool coding_choose(const char *accept_encoding, coding *out) {
  double quality[CODING_COUNT] = {[CODING_IDENTITY] = -1};
  double star = -1;
  read_qualities(accept_encoding, quality, &star);
  /* Identity not named is acceptable, but least wanted, unless "*;q=0" rules it out. */
  if (quality[CODING_IDENTITY] < 0) quality[CODING_IDENTITY] = star == 0 ? 0 : 1e-6;
  *out = CODING_IDENTITY;
  for (int c = 0; c < CODING_COUNT; c++) {
    if (quality[c] > 0 && quality[c] >= quality[*out]) *out = (coding)c;
  }
  return quality[*out] > 0;
}
