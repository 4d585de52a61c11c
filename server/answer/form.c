#include "form.h"

#include <stdio.h>

enum {
  ARRAYS = 1 << OUTPUT_ARRAY,
  PLACED = 1 << OUTPUT_COORDINATES | 1 << OUTPUT_FIELD | 1 << OUTPUT_COUNTS | 1 << OUTPUT_TENSOR,
  ANY = 1 << OUTPUT_OTHER | ARRAYS | PLACED
};

/* In the order of our preference. Roles: one output needs to have one of `alone`, a result at least
 * one output with one of `among`. */
static const struct {
  media media;
  unsigned alone, among;
} forms[] = {
    {MEDIA_JSON, ANY, ANY},
    {MEDIA_CBOR, ANY, ANY},
    {MEDIA_NPY, ARRAYS | PLACED, 0},
    {MEDIA_VTP, PLACED, PLACED},
    {MEDIA_CSV, ARRAYS | PLACED, PLACED},
    {MEDIA_MULTIPART, 0, ANY},
};
enum { FORMS = sizeof forms / sizeof *forms };

int forms_for_output(output_role role, media list[MEDIA_COUNT]) {
  int n = 0;
  for (int k = 0; k < FORMS; k++) {
    if (forms[k].alone & 1u << role) list[n++] = forms[k].media;
  }
  return n;
}

int forms_for_result(unsigned roles, media list[MEDIA_COUNT]) {
  int n = 0;
  for (int k = 0; k < FORMS; k++) {
    if (forms[k].among & roles) list[n++] = forms[k].media;
  }
  return n;
}

static bool is_among(media m, const media *list, int n) {
  for (int k = 0; k < n; k++) {
    if (list[k] == m) return true;
  }
  return false;
}

bool form_fits_output(media m, output_role role) {
  media list[MEDIA_COUNT];
  return is_among(m, list, forms_for_output(role, list));
}

bool form_fits_result(media m, unsigned roles) {
  media list[MEDIA_COUNT];
  return is_among(m, list, forms_for_result(roles, list));
}

static void name_all(const media *list, int n, char *room, size_t size) {
  size_t used = 0;
  for (int k = 0; k < n && used < size; k++) {
    const char *between = k == 0 ? "" : k == n - 1 ? " or " : ", ";
    used += (size_t)snprintf(room + used, size - used, "%s%s", between, media_type(list[k]));
  }
}

void forms_of_output(output_role role, char *room, size_t size) {
  media list[MEDIA_COUNT];
  name_all(list, forms_for_output(role, list), room, size);
}

void forms_of_result(unsigned roles, char *room, size_t size) {
  media list[MEDIA_COUNT];
  name_all(list, forms_for_result(roles, list), room, size);
}
