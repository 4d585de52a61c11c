#include "read.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const range range_any = {-INFINITY, INFINITY, true, true};
const range range_positive = {0, INFINITY, true, true};
const range range_not_negative = {0, INFINITY, false, true};

/* Items and pointers */

item item_body(const doc *body) {
  return (item){.doc = body};
}

item item_member(const item *of, const char *key) {
  return (item){.doc = of->doc ? doc_member(of->doc, key) : NULL, .up = of, .key = key};
}

item item_element(const item *of, const doc *element, int64_t index) {
  return (item){.doc = element, .up = of, .index = index};
}

static bool is_among(const char *name, const char *const *names) {
  for (; *names; names++) {
    if (!strcmp(name, *names)) return true;
  }
  return false;
}

static const char *const qualified_members[] = {"value", "mediaType", "encoding", "schema", NULL};

/* {"value": ...} as OGC API - Processes qualifies it: an object in it, or nothing unknown beside.
 */
static const doc *qualified_value(const doc *d) {
  const doc *value = doc_member(d, "value");
  if (!value || value->kind == DOC_OBJECT) return value;
  for (const doc *m = d->child; m; m = m->next) {
    if (!is_among(m->key, qualified_members)) return NULL;
  }
  return value;
}

item item_input(const item *inputs, const char *key) {
  item it = item_member(inputs, key);
  const doc *value = it.doc ? qualified_value(it.doc) : NULL;
  /* An object of free names may well have a number called "value" */
  bool is_parameter = !strcmp(key, "parameters") && value && value->kind != DOC_OBJECT;
  if (!value || is_parameter) return it;
  it.doc = value;
  it.wrapped = true;
  return it;
}

void item_unwrap(item *it) {
  const doc *value = it->doc ? qualified_value(it->doc) : NULL;
  if (!value || value->kind != DOC_OBJECT) return;
  it->doc = value;
  it->wrapped = true;
}

/* One step of a pointer, "~" and "/" escaped (RFC 6901 section 3). False if it does not fit. */
static bool append_key(char *room, size_t *used, const char *key) {
  size_t end = *used;
  if (end + 2 > PROBLEM_POINTER) return false;
  room[end++] = '/';
  for (const char *c = key; *c; c++) {
    if (end + 3 > PROBLEM_POINTER) return false;
    bool is_special = *c == '~' || *c == '/';
    if (is_special) room[end++] = '~';
    room[end++] = is_special ? *c == '~' ? '0' : '1' : *c;
  }
  *used = end;
  return true;
}

static bool append_step(char *room, size_t *used, const item *it) {
  char number[24] = "";
  if (!it->key) snprintf(number, sizeof number, "%lld", (long long)it->index);
  if (!append_key(room, used, it->key ? it->key : number)) return false;
  return !it->wrapped || append_key(room, used, "value");
}

void item_pointer(const item *at, char pointer[PROBLEM_POINTER]) {
  enum { DEPTH_MAX = 16 }; /* deeper than any reader goes */
  const item *chain[DEPTH_MAX];
  int depth = 0;
  size_t used = 0;
  for (const item *it = at; it->up && depth < DEPTH_MAX; it = it->up) chain[depth++] = it;
  while (depth > 0 && append_step(pointer, &used, chain[depth - 1])) depth--;
  pointer[used] = '\0';
}

void complain(task *t, const item *at, const char *format, ...) {
  char pointer[PROBLEM_POINTER], detail[PROBLEM_TEXT];
  va_list list;
  if (t->error.code == SCT_E_MEMORY) return; /* it may be about what could not be kept */
  va_start(list, format);
  vsnprintf(detail, sizeof detail, format, list);
  va_end(list);
  item_pointer(at, pointer);
  problem_add(&t->complaints, pointer, "%s", detail);
}

/* Words for messages */

const char *shown(const char *text, char room[SHOWN_MAX]) {
  size_t keep = strlen(text);
  if (keep > SHOWN_MAX - 8) {
    keep = SHOWN_MAX - 8;
    while (keep > 0 && ((unsigned char)text[keep] & 0xc0) == 0x80) keep--; /* within a character */
  }
  snprintf(room, SHOWN_MAX, "%.*s%s", (int)keep, text, text[keep] ? "..." : "");
  return room;
}

/* What a value is, for messages; short texts and numbers are quoted. */
static const char *got(const doc *d, char *room, size_t size) {
  char brief[SHOWN_MAX];
  if (d->kind == DOC_NUMBER) { /* integers with all their digits: they are compared with limits */
    const bool is_integer = fabs(d->number) < 1e18 && d->number == floor(d->number);
    snprintf(room, size, is_integer ? "%.0f" : "%.15g", d->number);
    return room;
  }
  if (d->kind == DOC_TEXT) {
    snprintf(room, size, "\"%s\"", shown(d->text, brief));
    return room;
  }
  return doc_describe(d, room, size);
}

static bool refuse(task *t, const item *it, const char *needed) {
  char room[128];
  complain(t, it, "is %s, needs %s", got(it->doc, room, sizeof room), needed);
  return false;
}

/* Edit distance of two short names; anything too long counts as far. */
static int distance(const char *a, const char *b) {
  enum { LONGEST = 40 };
  int row[LONGEST + 1], m = (int)strnlen(a, LONGEST + 1), n = (int)strnlen(b, LONGEST + 1);
  if (m > LONGEST || n > LONGEST) return LONGEST;
  for (int j = 0; j <= n; j++) row[j] = j;
  for (int i = 1; i <= m; i++) {
    int diagonal = row[0];
    row[0] = i;
    for (int j = 1; j <= n; j++) {
      int above = row[j], change = diagonal + (a[i - 1] != b[j - 1]);
      int skip = (above < row[j - 1] ? above : row[j - 1]) + 1;
      row[j] = change < skip ? change : skip;
      diagonal = above;
    }
  }
  return row[n];
}

const char *nearest_name(const char *name, const char *const *names) {
  const char *nearest = NULL;
  int least = (int)(strnlen(name, 12) + 2) / 3; /* a third of the letters may be wrong */
  for (; *names; names++) {
    int d = distance(name, *names);
    if (d > least || (nearest && d == least)) continue;
    least = d;
    nearest = *names;
  }
  return nearest;
}

/* "a, b or c" of a table of names. */
static void list_names(const char *const *names, char *room, size_t size) {
  size_t used = 0;
  room[0] = '\0';
  for (int k = 0; names[k] && used < size; k++) {
    const char *between = k == 0 ? "" : names[k + 1] ? ", " : " or ";
    used += (size_t)snprintf(room + used, size - used, "%s%s", between, names[k]);
  }
}

/* Readers */

bool read_required(task *t, const item *it) {
  if (it->doc) return true;
  complain(t, it, "is missing and required");
  return false;
}

void complain_unknown(task *t, const item *it, const char *kind, const char *const *names) {
  char room[SHOWN_MAX], known[512];
  const char *name = shown(it->key, room), *near = nearest_name(it->key, names);
  list_names(names, known, sizeof known);
  if (near) {
    complain(t, it, "unknown %s \"%s\"; did you mean \"%s\"?", kind, name, near);
  } else {
    complain(t, it, "unknown %s \"%s\", needs one of %s", kind, name, known);
  }
}

bool read_object(task *t, const item *it, const char *const *members) {
  if (!it->doc) return true;
  if (it->doc->kind != DOC_OBJECT) return refuse(t, it, "an object");
  bool known = true;
  for (const doc *m = it->doc->child; m && members; m = m->next) {
    if (is_among(m->key, members)) continue;
    item member = {.doc = m, .up = it, .key = m->key};
    complain_unknown(t, &member, "member", members);
    known = false;
  }
  return known;
}

/* "a number above 0", "a number from 0 to 1", "a number from 0 to below 1" */
static void describe_range(const range *r, char *room, size_t size) {
  char low[48] = "", high[48] = "";
  bool has_low = isfinite(r->low), has_high = isfinite(r->high);
  if (has_low) snprintf(low, sizeof low, r->above ? " above %.15g" : " from %.15g", r->low);
  if (has_high) snprintf(high, sizeof high, r->below ? " below %.15g" : " to %.15g", r->high);
  const char *and = has_low && has_high && (r->above || r->below) ? " and" : "";
  snprintf(room, size, "a %snumber%s%s%s", has_low || has_high ? "" : "finite ", low, and, high);
}

static bool is_in_range(double value, const range *r) {
  bool low = r->above ? value > r->low : value >= r->low;
  bool high = r->below ? value < r->high : value <= r->high;
  return low && high; /* false for NaN */
}

bool read_qualified(task *t, const item *it) {
  return !it->doc || !qualified_value(it->doc) || read_object(t, it, qualified_members);
}

bool read_number(task *t, const item *it, const range *r, double *value) {
  if (!it->doc) return true;
  char needed[128];
  describe_range(r, needed, sizeof needed);
  if (it->doc->kind != DOC_NUMBER) return refuse(t, it, needed);
  if (!isfinite(it->doc->number)) return refuse(t, it, "a finite number");
  if (!is_in_range(it->doc->number, r)) return refuse(t, it, needed);
  *value = it->doc->number;
  return true;
}

static bool is_integer_in(double value, int64_t low, int64_t high) {
  return value >= (double)low && value <= (double)high && value == floor(value);
}

bool read_integer(task *t, const item *it, int64_t low, int64_t high, int64_t *value) {
  if (!it->doc) return true;
  char needed[96];
  snprintf(needed, sizeof needed, "an integer from %lld to %lld", (long long)low, (long long)high);
  if (it->doc->kind != DOC_NUMBER) return refuse(t, it, needed);
  if (!is_integer_in(it->doc->number, low, high)) return refuse(t, it, needed);
  *value = (int64_t)it->doc->number;
  return true;
}

bool read_boolean(task *t, const item *it, bool *value) {
  if (!it->doc) return true;
  if (it->doc->kind != DOC_BOOL) return refuse(t, it, "true or false");
  *value = it->doc->truth;
  return true;
}

bool read_text(task *t, const item *it, const char **value) {
  if (!it->doc) return true;
  if (it->doc->kind != DOC_TEXT) return refuse(t, it, "a string");
  if (strlen(it->doc->text) != it->doc->length) {
    complain(t, it, "holds a NUL character, needs a string without");
    return false;
  }
  *value = it->doc->text;
  return true;
}

bool read_choice(task *t, const item *it, const char *const *names, int *value) {
  const char *text = NULL;
  char known[512];
  if (!it->doc) return true;
  if (!read_text(t, it, &text)) return false;
  for (int k = 0; names[k]; k++) {
    if (strcmp(names[k], text)) continue;
    *value = k;
    return true;
  }
  list_names(names, known, sizeof known);
  return refuse(t, it, known);
}

/* Arrays */

int item_rank(const item *it) {
  const doc *d = it->doc;
  if (!d || (d->kind != DOC_NUMBERS && d->kind != DOC_LIST)) return 0;
  if (d->kind == DOC_NUMBERS) return d->rank;
  bool has_rows = d->child && (d->child->kind == DOC_NUMBERS || d->child->kind == DOC_LIST);
  return has_rows ? 2 : 1;
}

/* Complains about the number at flat place k of an array. */
static void refuse_entry(task *t, const item *it, int rank, int64_t k, const char *needed) {
  int64_t columns = rank == 2 ? it->doc->shape[1] : 1;
  item row = item_element(it, NULL, k / columns), entry = item_element(&row, NULL, k % columns);
  complain(t, rank == 2 ? &entry : &row, "is %.15g, needs %s", it->doc->data[k], needed);
}

static bool entries_are_finite(task *t, const item *it, int rank) {
  bool finite = true;
  for (int64_t k = 0; k < it->doc->count; k++) {
    if (isfinite(it->doc->data[k])) continue;
    refuse_entry(t, it, rank, k, "a finite number");
    finite = false;
  }
  return finite;
}

/* The elements of a list that keep it from being a row of numbers. */
static void refuse_row(task *t, const item *it) {
  int64_t k = 0;
  for (const doc *d = it->doc->child; d; d = d->next, k++) {
    item element = item_element(it, d, k);
    if (d->kind != DOC_NUMBER) {
      refuse(t, &element, "a number");
    } else if (!isfinite(d->number)) {
      complain(t, &element, "is %.15g, needs a finite number", d->number);
    }
  }
}

/* Length of the first row of numbers in a list, -1 if there is none. */
static int64_t first_row_length(const doc *list) {
  for (const doc *d = list->child; d; d = d->next) {
    if (d->kind == DOC_NUMBERS && d->rank == 1) return d->count;
  }
  return -1;
}

/* The elements of a list that keep it from being equally long rows of numbers. */
static void refuse_rows(task *t, const item *it) {
  int64_t columns = first_row_length(it->doc), k = 0;
  char needed[64] = "an array of numbers";
  if (columns >= 0) {
    snprintf(needed, sizeof needed, "an array of %lld numbers like the first", (long long)columns);
  }
  for (const doc *d = it->doc->child; d; d = d->next, k++) {
    item element = item_element(it, d, k);
    bool is_row = d->kind == DOC_NUMBERS && d->rank == 1;
    if (d->kind == DOC_LIST) {
      refuse_row(t, &element);
    } else if (!is_row || d->count != columns) {
      refuse(t, &element, needed);
    } else {
      (void)entries_are_finite(t, &element, 1);
    }
  }
}

static bool refuse_array(task *t, const item *it, int rank) {
  int before = t->complaints.found;
  if (it->doc->kind == DOC_LIST && rank == 2) refuse_rows(t, it);
  if (it->doc->kind == DOC_LIST && rank == 1) refuse_row(t, it);
  if (t->complaints.found > before) return false;
  return refuse(t, it, rank == 2 ? "an array of arrays of numbers" : "an array of numbers");
}

bool read_numbers(task *t, const item *it, int rank, numbers *value) {
  const doc *d = it->doc;
  if (!d) return true;
  bool is_empty = d->kind == DOC_NUMBERS && d->count == 0;
  if (is_empty) {
    *value = (numbers){0, rank == 2 ? 0 : 1, NULL};
    return true;
  }
  if (d->kind != DOC_NUMBERS || d->rank != rank) return refuse_array(t, it, rank);
  if (!entries_are_finite(t, it, rank)) return false;
  *value = (numbers){d->shape[0], rank == 2 ? d->shape[1] : 1, d->data};
  return true;
}

/* The elements of a list that are no such integers. */
static bool refuse_integers(task *t, const item *it, int64_t low, int64_t high) {
  int before = t->complaints.found;
  int64_t k = 0, ignored;
  for (const doc *d = it->doc->child; d; d = d->next, k++) {
    item element = item_element(it, d, k);
    (void)read_integer(t, &element, low, high, &ignored);
  }
  return t->complaints.found == before && refuse_array(t, it, 1);
}

bool read_integers(task *t, const item *it, int64_t low, int64_t high, numbers *value) {
  const doc *d = it->doc;
  char needed[96];
  bool good = true;
  if (!d) return true;
  if (d->kind == DOC_LIST) return refuse_integers(t, it, low, high);
  if (d->kind != DOC_NUMBERS || d->rank != 1) return read_numbers(t, it, 1, value);
  snprintf(needed, sizeof needed, "an integer from %lld to %lld", (long long)low, (long long)high);
  for (int64_t k = 0; k < d->count; k++) {
    if (is_integer_in(d->data[k], low, high)) continue;
    refuse_entry(t, it, 1, k, needed);
    good = false;
  }
  if (good) *value = (numbers){d->shape[0], 1, d->data};
  return good;
}
