/* JSON to document: scan_json checks and takes the numbers out, cJSON reads the structure of what
 * is left, and here both are put together. The only door to cJSON for decoding. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

#include "doc_tree.h"
#include "scan_json.h"

typedef struct {
  doc_tree tree;
  const scan_shape *shape; /* of the next array of numbers */
} splice;

static bool take(splice *s, const cJSON *item);

static bool take_children(splice *s, const cJSON *item, doc_kind kind) {
  if (!doc_tree_open(&s->tree, kind)) return false;
  for (const cJSON *child = item->child; child != NULL; child = child->next) {
    if (child->string != NULL && !doc_tree_key(&s->tree, child->string, strlen(child->string))) {
      return false;
    }
    if (!take(s, child)) return false;
  }
  doc_tree_close(&s->tree);
  return true;
}

/* A mark of the scanner, or a text of the client. The cJSON tree is ours: NUL is put back there. */
static bool take_string(splice *s, const cJSON *item) {
  char *text = item->valuestring;
  if ((unsigned char)text[0] == SCAN_ARRAY) {
    const scan_shape *shape = s->shape++;
    return doc_tree_numbers(&s->tree, shape->rank, shape->shape);
  }
  size_t length = strlen(text);
  for (char *p = text; (p = strchr(p, SCAN_NUL)) != NULL;) *p++ = '\0';
  return doc_tree_text(&s->tree, text, length);
}

/* Recursion as deep as the document; the scanner has checked its depth. */
static bool take(splice *s, const cJSON *item) {
  if (cJSON_IsObject(item)) return take_children(s, item, DOC_OBJECT);
  if (cJSON_IsArray(item)) return take_children(s, item, DOC_LIST);
  if (cJSON_IsString(item)) return take_string(s, item);
  if (cJSON_IsNumber(item)) return doc_tree_number(&s->tree);
  if (cJSON_IsBool(item)) return doc_tree_bool(&s->tree, cJSON_IsTrue(item));
  return doc_tree_null(&s->tree);
}

/* After the scan only memory can be missing. */
static bool build(splice *s, scan_result *scanned, const doc_limits *limits, doc_arena *arena) {
  cJSON *json = cJSON_ParseWithLength(scanned->text.data, scanned->text.size);
  int depth = limits->depth < DOC_DEPTH_MAX ? limits->depth : DOC_DEPTH_MAX;
  s->shape = scanned->shapes;
  bool fine = json != NULL && doc_tree_start(&s->tree, arena, depth) && take(s, json);
  cJSON_Delete(json);
  if (fine && scanned->values != NULL) {
    double *values = scanned->values;
    scanned->values = NULL;
    fine = doc_arena_keep(arena, values);
    if (fine) doc_tree_settle(&s->tree, values);
  }
  return fine;
}

const doc *doc_from_json(const char *body, size_t size, const doc_limits *limits, doc_arena **arena,
                         doc_error *error) {
  splice s = {0};
  scan_result scanned = {0};
  *error = (doc_error){.offset = -1};
  *arena = doc_arena_new();
  bool scanned_fine = *arena != NULL && scan_json(body, size, limits, *arena, &scanned, error);
  bool fine = scanned_fine && build(&s, &scanned, limits, *arena);
  if (!fine && (*arena == NULL || scanned_fine)) doc_no_memory(error);
  if (error->offset < 0) error->offset = 0;
  scan_result_free(&scanned);
  return fine ? s.tree.root : NULL;
}
