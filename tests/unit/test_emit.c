/* Encoding: exact bytes, misuse, and every number back bit for bit. */
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "emit.h"
#include "seed.h"

static const doc_limits wide = {.depth = 100, .nodes = 1000000, .numbers = 10000000};

typedef const doc *decoder(const char *body, size_t size, doc_arena **arena);

static const doc *from_json(const char *body, size_t size, doc_arena **arena) {
  doc_error error;
  return doc_from_json(body, size, &wide, arena, &error);
}

static const doc *from_cbor(const char *body, size_t size, doc_arena **arena) {
  doc_error error;
  return doc_from_cbor(body, size, &wide, arena, &error);
}

static decoder *const decoders[] = {[EMIT_JSON] = from_json, [EMIT_CBOR] = from_cbor};
static const emit_format formats[] = {EMIT_JSON, EMIT_CBOR};
enum { FORMATS = 2 };

/* ---- exact bytes ---- */

/* JSON as it is, CBOR as hexadecimal digits; NULL if something failed. */
static char *written(emit *e, emit_format format) {
  size_t size;
  const unsigned char *bytes = emit_bytes(e, &size);
  if (!emit_ok(e)) return NULL;
  char *text = calloc(size + 1, 2);
  for (size_t k = 0; k < size; k++) {
    if (format == EMIT_JSON) {
      text[k] = (char)bytes[k];
    } else {
      sprintf(text + 2 * k, "%02x", bytes[k]);
    }
  }
  return text;
}

static void check(void (*write)(emit *), const char *json, const char *cbor) {
  const char *expected[] = {[EMIT_JSON] = json, [EMIT_CBOR] = cbor};
  for (int k = 0; k < FORMATS; k++) {
    emit *e = emit_new(formats[k]);
    write(e);
    char *text = written(e, formats[k]);
    assert_non_null(text);
    assert_string_equal(text, expected[formats[k]]);
    free(text);
    emit_free(&e);
    assert_null(e);
  }
}

static void write_object(emit *e) {
  emit_object(e);
  emit_key(e, "a");
  emit_integer(e, 1);
  emit_key(e, "b");
  emit_list(e);
  emit_null(e);
  emit_bool(e, true);
  emit_bool(e, false);
  emit_object(e);
  emit_end(e);
  emit_list(e);
  emit_end(e);
  emit_text(e, "x");
  emit_end(e);
  emit_key(e, "");
  emit_number(e, 0.5);
  emit_end(e);
}

static void test_containers(void **state) {
  (void)state;
  check(write_object, "{\"a\":1,\"b\":[null,true,false,{},[],\"x\"],\"\":0.5}",
        "bf6161016162"
        "9ff6f5f4bfff9fff6178ff"
        "60fa3f000000"
        "ff");
}

static void write_integers(emit *e) {
  static const int64_t values[] = {0,          23,        24, 256, 65536,
                                   4294967296, INT64_MAX, -1, -25, INT64_MIN};
  emit_list(e);
  for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) emit_integer(e, values[k]);
  emit_end(e);
}

static void write_numbers(emit *e) {
  static const double values[] = {
      0,     -0.0,   1,    -2.5, 0.1,  0x1p53,         -0x1p53,     0x1p54,   1e21,
      1e100, 5e-324, 1e-7, 100,  1e15, 0x1.fffffep127, (double)NAN, HUGE_VAL, -HUGE_VAL};
  emit_list(e);
  for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) emit_number(e, values[k]);
  emit_end(e);
}

static void test_numbers(void **state) {
  (void)state;
  check(write_integers,
        "[0,23,24,256,65536,4294967296,9223372036854775807,-1,-25,-9223372036854775808]",
        "9f00171818190100"
        "1a00010000"
        "1b0000000100000000"
        "1b7fffffffffffffff"
        "203818"
        "3b7fffffffffffffff"
        "ff");
  check(write_numbers,
        "[0,-0,1,-2.5,0.1,9007199254740992,-9007199254740992,18014398509481984,1e+21,1e+100,5e-324,"
        "1e-07,100,1000000000000000,3.4028234663852886e+38,null,null,null]",
        "9ffa00000000fa80000000fa3f800000fac0200000fb3fb999999999999a"
        "fa5a000000fada000000fa5a800000"
        "fb444b1ae4d6e2ef50fb54b249ad2594c37dfb0000000000000001fb3e7ad7f29abcaf48fa42c80000"
        "fb430c6bf526340000fa7f7fffff"
        "fa7fc00000"
        "fa7f800000faff800000ff");
}

static void write_texts(emit *e) {
  emit_list(e);
  emit_text(e, "\"\\/\b\f\n\r\t\x1F\x7F");
  emit_text_n(e, "a\0b", 3);
  emit_text(e, "\u00e9\U0001F600");
  emit_text(e, "cut \xE6\xB0");
  emit_end(e);
}

static void test_texts(void **state) {
  (void)state;
  check(write_texts,
        "[\"\\\"\\\\/\\b\\f\\n\\r\\t\\u001f\x7F\",\"a\\u0000b\",\"\u00e9\U0001F600\","
        "\"cut \uFFFD\uFFFD\"]",
        "9f6a225c2f080c0a0d091f7f"
        "63610062"
        "66c3a9f09f9880"
        "7f646375742063efbfbd63efbfbdff"
        "ff");
}

static void write_arrays(emit *e) {
  static const double d[] = {1, -0.5, 0x1p53, 4};
  static const int32_t i[] = {1, -2, INT32_MAX, INT32_MIN};
  emit_list(e);
  emit_doubles(e, d, 1, (int64_t[]){2});
  emit_doubles(e, d, 2, (int64_t[]){2, 1});
  emit_doubles(e, d, 3, (int64_t[]){1, 2, 2});
  emit_doubles(e, NULL, 1, (int64_t[]){0});
  emit_int32s(e, i, 1, (int64_t[]){4});
  emit_int32s(e, i, 2, (int64_t[]){1, 2});
  emit_doubles(e, NULL, 2, (int64_t[]){2, 0});
  emit_end(e);
}

static void test_arrays(void **state) {
  (void)state;
  check(write_arrays,
        "[[1,-0.5],[[1],[-0.5]],[[[1,-0.5],[9007199254740992,4]]],[],"
        "[1,-2,2147483647,-2147483648],[[1,-2]],[[],[]]]",
        "9f"
        "d85650000000000000f03f000000000000e0bf"
        "d82882820201d85650000000000000f03f000000000000e0bf"
        "d8288283010202d8565820000000000000f03f000000000000e0bf00000000000040430000000000001040"
        "d85640"
        "d84e5001000000feffffffffffff7f00000080"
        "d82882820102d84e4801000000feffffff"
        "d82882820200d85640"
        "ff");
}

/* ---- misuse ---- */

static void key_in_list(emit *e) {
  emit_list(e), emit_key(e, "a");
}
static void value_without_key(emit *e) {
  emit_object(e), emit_null(e);
}
static void two_keys(emit *e) {
  emit_object(e), emit_key(e, "a"), emit_key(e, "b");
}
static void end_after_key(emit *e) {
  emit_object(e), emit_key(e, "a"), emit_end(e);
}
static void end_too_many(emit *e) {
  emit_list(e), emit_end(e), emit_end(e);
}
static void two_roots(emit *e) {
  emit_null(e), emit_null(e);
}
static void key_at_root(emit *e) {
  emit_key(e, "a");
}
static void negative_shape(emit *e) {
  emit_doubles(e, NULL, 1, (int64_t[]){-1});
}
static void huge_shape(emit *e) {
  emit_int32s(e, NULL, 2, (int64_t[]){INT64_MAX, 2});
}
static void rank_four(emit *e) {
  emit_doubles(e, NULL, 4, (int64_t[]){0, 0, 0, 0});
}
static void too_deep(emit *e) {
  for (int k = 0; k < 10000; k++) emit_list(e);
}

static void test_misuse(void **state) {
  static void (*const writers[])(emit *) = {
      key_in_list, value_without_key, two_keys,   end_after_key, end_too_many, two_roots,
      key_at_root, negative_shape,    huge_shape, rank_four,     too_deep,
  };
  (void)state;
  for (size_t k = 0; k < sizeof writers / sizeof writers[0]; k++) {
    for (int f = 0; f < FORMATS; f++) {
      emit *e = emit_new(formats[f]);
      size_t before, after;
      writers[k](e);
      assert_false(emit_ok(e));
      emit_bytes(e, &before);
      write_arrays(e);
      emit_bytes(e, &after);
      assert_false(emit_ok(e));
      assert_int_equal(before, after);
      emit_free(&e);
    }
  }
}

/* ---- there and back ---- */

enum { NUMBERS = 100000 };

/* Any bit pattern but NaN: subnormals, extremes, and integers around 2^53. */
static double any_double(uint64_t *r) {
  static const double special[] = {0.0,       -0.0,      5e-324,     -5e-324,
                                   0x1p-1022, 0x1p-1074, 0x1p1023,   0x1.fffffffffffffp1023,
                                   0x1p53,    -0x1p53,   0x1p53 + 2, 0x1.fffffffffffffp-1023,
                                   1e22,      1e23};
  uint64_t bits = seed_next(r);
  double value;
  switch (bits & 7) {
    case 0:
      return special[seed_below(r, sizeof special / sizeof special[0])];
    case 1:
      bits &= 0x800FFFFFFFFFFFFFu;
      break; /* subnormal */
    case 2:
      return (double)((int64_t)bits >> seed_below(r, 64));
    case 3:
      return (double)(int64_t)(bits >> 40) / 1000;
    default:
      break;
  }
  memcpy(&value, &bits, sizeof value);
  return isfinite(value) ? value : any_double(r);
}

static double *any_doubles(uint64_t *r) {
  double *values = malloc(NUMBERS * sizeof *values);
  for (int k = 0; k < NUMBERS; k++) values[k] = any_double(r);
  return values;
}

static void check_back(emit_format format, const double *values, int rank, const int64_t *shape) {
  size_t size;
  doc_arena *arena;
  emit *e = emit_new(format);
  emit_doubles(e, values, rank, shape);
  assert_true(emit_ok(e));
  const char *bytes = emit_bytes(e, &size);
  const doc *d = decoders[format](bytes, size, &arena);
  assert_non_null(d);
  assert_int_equal(d->kind, DOC_NUMBERS);
  assert_int_equal(d->rank, rank);
  assert_memory_equal(d->shape, shape, (size_t)rank * sizeof *shape);
  assert_memory_equal(d->data, values, NUMBERS * sizeof *values);
  doc_arena_free(&arena);
  emit_free(&e);
}

static void test_arrays_back(void **state) {
  uint64_t r = seed_new("unit.emit");
  double *values = any_doubles(&r);
  (void)state;
  for (int f = 0; f < FORMATS; f++) {
    check_back(formats[f], values, 1, (int64_t[]){NUMBERS});
    check_back(formats[f], values, 2, (int64_t[]){NUMBERS / 4, 4});
    check_back(formats[f], values, 2, (int64_t[]){NUMBERS, 1});
    check_back(formats[f], values, 3, (int64_t[]){4, 5, NUMBERS / 20});
  }
  free(values);
}

static void test_scalars_back(void **state) {
  uint64_t r = seed_new("unit.emit");
  double *values = any_doubles(&r);
  (void)state;
  for (int f = 0; f < FORMATS; f++) {
    size_t size;
    doc_arena *arena;
    emit *e = emit_new(formats[f]);
    emit_list(e);
    for (int k = 0; k < NUMBERS; k++) emit_number(e, values[k]);
    emit_null(e); /* else it would be an array of numbers */
    emit_end(e);
    const char *bytes = emit_bytes(e, &size);
    const doc *d = decoders[formats[f]](bytes, size, &arena);
    assert_int_equal(d->kind, DOC_LIST);
    const doc *child = d->child;
    for (int k = 0; k < NUMBERS; k++, child = child->next) {
      assert_memory_equal(&child->number, &values[k], sizeof values[k]);
    }
    doc_arena_free(&arena);
    emit_free(&e);
  }
  free(values);
}

/* No longer than printf's shortest %e that reads back. */
static void test_shortest(void **state) {
  uint64_t r = seed_new("unit.emit");
  (void)state;
  for (int k = 0; k < 20000; k++) {
    double value = any_double(&r);
    char shortest[64];
    size_t size;
    int digits = -1;
    emit *e = emit_new(EMIT_JSON);
    emit_number(e, value);
    const char *text = emit_bytes(e, &size);
    do {
      snprintf(shortest, sizeof shortest, "%.*e", ++digits, value);
    } while (strtod(shortest, NULL) != value);
    bool integer = fabs(value) <= 0x1p53 && value == floor(value);
    if (!integer && size > strlen(shortest)) {
      fail_msg("%.*s: %s is shorter", (int)size, text, shortest);
    }
    emit_free(&e);
  }
}

/* A document of every kind, from JSON to CBOR to JSON. */
static void test_documents_back(void **state) {
  static const char json[] =
      "{\"a\":[1,2.5,-3],\"b\":[[1,2],[3,4]],\"c\":[[[1],[2]]],\"d\":[[1],[2,3]],\"e\":[],\"f\":{},"
      "\"g\":[null,true,false,\"x\\n\\u0000\u00e9\",7,{\"h\":-0}],\"\":\"\"}";
  doc_arena *first, *second;
  size_t size;
  (void)state;
  emit *cbor = emit_new(EMIT_CBOR), *back = emit_new(EMIT_JSON);
  emit_doc(cbor, from_json(json, sizeof json - 1, &first));
  const char *bytes = emit_bytes(cbor, &size);
  emit_doc(back, from_cbor(bytes, size, &second));
  assert_true(emit_ok(back));
  bytes = emit_bytes(back, &size);
  assert_int_equal(size, sizeof json - 1);
  assert_memory_equal(bytes, json, size);
  doc_arena_free(&first);
  doc_arena_free(&second);
  emit_free(&cbor);
  emit_free(&back);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_containers),     cmocka_unit_test(test_numbers),
      cmocka_unit_test(test_texts),          cmocka_unit_test(test_arrays),
      cmocka_unit_test(test_misuse),         cmocka_unit_test(test_arrays_back),
      cmocka_unit_test(test_scalars_back),   cmocka_unit_test(test_shortest),
      cmocka_unit_test(test_documents_back),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
