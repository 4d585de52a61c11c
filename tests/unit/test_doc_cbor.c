/* CBOR decoding: the examples of RFC 8949, appendix A, typed arrays, limits, errors with place and
 * pointer. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "doc.h"
#include "doc_show.h"
#include "typed_array.h"

static const doc_limits wide = {.depth = 100, .nodes = 100000, .numbers = 1000000};

/* Hexadecimal digits, blanks between them allowed, to bytes: malloc'ed exactly, so that a sanitizer
 * sees any step beyond the end. */
static unsigned char *bytes_of(const char *hex, size_t *size) {
  unsigned char *bytes = malloc(strlen(hex) / 2 + 1);
  unsigned byte;
  *size = 0;
  for (int used; sscanf(hex, " %2x%n", &byte, &used) == 1; hex += used) {
    bytes[(*size)++] = (unsigned char)byte;
  }
  return realloc(bytes, *size == 0 ? 1 : *size);
}

/* What comes out, or the text of the error; the caller frees it. */
static char *decode(const char *hex, const doc_limits *limits, doc_error *error) {
  size_t size;
  doc_arena *arena;
  unsigned char *body = bytes_of(hex, &size);
  const doc *d = doc_from_cbor(body, size, limits, &arena, error);
  char *text = d == NULL ? strdup(error->text) : doc_show(d);
  doc_arena_free(&arena);
  assert_null(arena);
  free(body);
  return text;
}

typedef struct {
  const char *hex, *shown;
} example;

static void check_examples(const example *examples, size_t n) {
  int wrong = 0;
  for (size_t k = 0; k < n; k++) {
    doc_error error;
    char *shown = decode(examples[k].hex, &wide, &error);
    bool same = strcmp(shown, examples[k].shown) == 0;
    if (!same) print_error("%s: got %s, expected %s\n", examples[k].hex, shown, examples[k].shown);
    wrong += !same;
    free(shown);
  }
  assert_int_equal(wrong, 0);
}

#define CHECK(examples) check_examples(examples, sizeof(examples) / sizeof((examples)[0]))

/* ---- RFC 8949, appendix A, in its order ---- */

static void test_appendix_numbers(void **state) {
  static const example examples[] = {
      {"00", "0"},
      {"01", "1"},
      {"0a", "10"},
      {"17", "23"},
      {"1818", "24"},
      {"1819", "25"},
      {"1864", "100"},
      {"1903e8", "1000"},
      {"1a000f4240", "1000000"},
      {"1b000000e8d4a51000", "1000000000000"},
      {"1bffffffffffffffff", "1.8446744073709552e+19"},
      {"3bffffffffffffffff", "-1.8446744073709552e+19"},
      {"20", "-1"},
      {"29", "-10"},
      {"3863", "-100"},
      {"3903e7", "-1000"},
      {"f90000", "0"},
      {"f98000", "-0"},
      {"f93c00", "1"},
      {"fb3ff199999999999a", "1.1000000000000001"},
      {"f93e00", "1.5"},
      {"f97bff", "65504"},
      {"fa47c35000", "100000"},
      {"fa7f7fffff", "3.4028234663852886e+38"},
      {"fb7e37e43c8800759c", "1.0000000000000001e+300"},
      {"f90001", "5.9604644775390625e-08"},
      {"f90400", "6.103515625e-05"},
      {"f9c400", "-4"},
      {"fbc010666666666666", "-4.0999999999999996"},
      {"f97c00", "inf"},
      {"f97e00", "nan"},
      {"f9fc00", "-inf"},
      {"fa7f800000", "inf"},
      {"fa7fc00000", "nan"},
      {"faff800000", "-inf"},
      {"fb7ff0000000000000", "inf"},
      {"fb7ff8000000000000", "nan"},
      {"fbfff0000000000000", "-inf"},
      {"3b001fffffffffffff", "-9007199254740992"},
      {"3b0020000000000001", "-9007199254740994"},
  };
  (void)state;
  CHECK(examples);
}

static void test_appendix_others(void **state) {
  static const example examples[] = {
      {"f4", "false"},
      {"f5", "true"},
      {"f6", "null"},
      {"60", "\"\""},
      {"6161", "\"a\""},
      {"6449455446", "\"IETF\""},
      {"62225c", "\"\"\\\""},
      {"62c3bc", "\"\u00fc\""},
      {"63e6b0b4", "\"\u6c34\""},
      {"64f0908591", "\"\U00010151\""},
      {"80", "<0:>"},
      {"83010203", "<3: 1 2 3>"},
      {"8301820203820405", "[1, <2: 2 3>, <2: 4 5>]"},
      {"98190102030405060708090a0b0c0d0e0f101112131415161718181819",
       "<25: 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25>"},
      {"a0", "{}"},
      {"a26161016162820203", "{\"a\": 1, \"b\": <2: 2 3>}"},
      {"826161a161626163", "[\"a\", {\"b\": \"c\"}]"},
      {"a56161614161626142616361436164614461656145",
       "{\"a\": \"A\", \"b\": \"B\", \"c\": \"C\", \"d\": \"D\", \"e\": \"E\"}"},
      {"7f657374726561646d696e67ff", "\"streaming\""},
      {"9fff", "<0:>"},
      {"9f018202039f0405ffff", "[1, <2: 2 3>, <2: 4 5>]"},
      {"9f01820203820405ff", "[1, <2: 2 3>, <2: 4 5>]"},
      {"83018202039f0405ff", "[1, <2: 2 3>, <2: 4 5>]"},
      {"83019f0203ff820405", "[1, <2: 2 3>, <2: 4 5>]"},
      {"9f0102030405060708090a0b0c0d0e0f101112131415161718181819ff",
       "<25: 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25>"},
      {"bf61610161629f0203ffff", "{\"a\": 1, \"b\": <2: 2 3>}"},
      {"826161bf61626163ff", "[\"a\", {\"b\": \"c\"}]"},
      {"bf6346756ef563416d7421ff", "{\"Fun\": true, \"Amt\": -2}"},
  };
  (void)state;
  CHECK(examples);
}

/* The examples this model has no place for: each says why. */
static void test_appendix_refused(void **state) {
  static const example examples[] = {
      {"c249010000000000000000", "byte 0: got tag 2, which is not supported"},
      {"c349010000000000000000", "byte 0: got tag 3, which is not supported"},
      {"f7", "byte 0: got undefined, needed a value"},
      {"f0", "byte 0: got byte 0xF0, which begins no CBOR value"},
      {"f8ff", "byte 0: got byte 0xF8, which begins no CBOR value"},
      {"c074323031332d30332d32315432303a30343a30305a", "byte 0: got tag 0, which is not supported"},
      {"c11a514b67b0", "byte 0: got tag 1, which is not supported"},
      {"c1fb41d452d9ec200000", "byte 0: got tag 1, which is not supported"},
      {"d74401020304", "byte 0: got tag 23, which is not supported"},
      {"d818456449455446", "byte 0: got tag 24, which is not supported"},
      {"d82076687474703a2f2f7777772e6578616d706c652e636f6d",
       "byte 0: got tag 32, which is not supported"},
      {"40", "byte 0: got a byte string, needed a tag of a typed array before it"},
      {"4401020304", "byte 0: got a byte string, needed a tag of a typed array before it"},
      {"5f42010243030405ff", "byte 8: got a byte string, needed a tag of a typed array before it"},
      {"a201020304", "byte 1: got a number as a key, needed a text"},
  };
  (void)state;
  CHECK(examples);
}

/* ---- RFC 8746 ---- */

static void test_typed_arrays(void **state) {
  static const example examples[] = {
      {"d840 43 0080ff", "<3: 0 128 255>"},
      {"d844 43 0080ff", "<3: 0 128 255>"},
      {"d841 44 0001ff00", "<2: 1 65280>"},
      {"d845 44 010000ff", "<2: 1 65280>"},
      {"d842 48 00000001ffffffff", "<2: 1 4294967295>"},
      {"d846 48 01000000ffffffff", "<2: 1 4294967295>"},
      {"d843 50 0000000000000001 ffffffffffffffff", "<2: 1 1.8446744073709552e+19>"},
      {"d847 50 0100000000000000 ffffffffffffffff", "<2: 1 1.8446744073709552e+19>"},
      {"d848 43 0080ff", "<3: 0 -128 -1>"},
      {"d849 44 0001ff00", "<2: 1 -256>"},
      {"d84d 44 010000ff", "<2: 1 -256>"},
      {"d84a 48 00000001fffffffe", "<2: 1 -2>"},
      {"d84e 48 01000000feffffff", "<2: 1 -2>"},
      {"d84b 50 0000000000000001 8000000000000000", "<2: 1 -9.2233720368547758e+18>"},
      {"d84f 50 0100000000000000 0000000000000080", "<2: 1 -9.2233720368547758e+18>"},
      {"d850 46 3c00c4000001", "<3: 1 -4 5.9604644775390625e-08>"},
      {"d854 46 003c00c40100", "<3: 1 -4 5.9604644775390625e-08>"},
      {"d851 48 3f800000ff800000", "<2: 1 -inf>"},
      {"d855 48 0000803f000080ff", "<2: 1 -inf>"},
      {"d852 50 3ff0000000000000 3ff199999999999a", "<2: 1 1.1000000000000001>"},
      {"d856 50 000000000000f03f 9a9999999999f13f", "<2: 1 1.1000000000000001>"},
      {"d856 40", "<0:>"},
      {"d840 5f 4101 420203 40 ff", "<3: 1 2 3>"},
      {"82 d840 420102 d845 4403000400", "<2x2: 1 2 3 4>"},
      {"82 d840 420102 d840 4103", "[<2: 1 2>, <1: 3>]"},
      {"a1 6161 d840 420102", "{\"a\": <2: 1 2>}"},
      {"82 01 d840 420102", "[1, <2: 1 2>]"},
      {"d9d9f7 d840 420102", "<2: 1 2>"},
      {"82 d9d9f7 d9d9f7 01 02", "<2: 1 2>"},
  };
  (void)state;
  CHECK(examples);
}

/* RFC 8746, figures 1 and 2: [[2, 4, 8], [4, 16, 256]] by rows and by columns. */
static void test_shapes(void **state) {
  static const example examples[] = {
      {"d828 82 820203 d841 4c 000200040008000400100100", "<2x3: 2 4 8 4 16 256>"},
      {"d828 82 820203 86 020408 0410190100", "<2x3: 2 4 8 4 16 256>"},
      {"d90410 82 820203 86 020404 1008190100", "<2x3: 2 4 8 4 16 256>"},
      {"d90410 82 83020302 8c 000102030405060708090a0b", "<2x3x2: 0 6 2 8 4 10 1 7 3 9 5 11>"},
      {"d90410 82 8103 83 010203", "<3: 1 2 3>"},
      {"d828 82 8103 d840 43010203", "<3: 1 2 3>"},
      {"d828 9f 9f0102ff 9f0102ff ff", "<1x2: 1 2>"},
      {"d828 82 d840 420201 d840 420102", "<2x1: 1 2>"},
      {"d828 82 820200 80", "<0:>"},
      {"d828 82 820002 d856 40", "<0:>"},
      {"d90410 82 820002 d856 40", "<0:>"},
      {"82 d828 82 8102 820102 d828 82 8102 820304", "<2x2: 1 2 3 4>"},
      {"a2 6161 d828 82 820201 820102 6162 03", "{\"a\": <2x1: 1 2>, \"b\": 3}"},
      {"83 01 d828 82 820201 820102 03", "[1, <2x1: 1 2>, 3]"},
  };
  (void)state;
  CHECK(examples);
}

static void test_shapes_refused(void **state) {
  static const example examples[] = {
      {"d828 01", "byte 2: got a number behind tag 40, which does not go with it"},
      {"d828 d840 4101", "byte 2: got a tag behind tag 40, which does not go with it"},
      {"d828 80", "byte 3: an array with dimensions needs [dimensions, numbers]"},
      {"d828 81 8101", "byte 5: an array with dimensions needs [dimensions, numbers]"},
      {"d828 83 8101 8101 8101",
       "byte 9: an array with dimensions needs [dimensions, numbers] and no more"},
      {"d828 82 8102 8101",
       "byte 7: numbers of an array with dimensions: got 1, needed the product of the dimensions"},
      {"d828 82 02 8101", "byte 3: an array with dimensions needs [dimensions, numbers]"},
      {"d828 82 80 8101", "byte 4: dimensions of an array: needed a list of 1 to 3 integers"},
      {"d828 82 8401010101 8101",
       "byte 8: dimensions of an array: needed a list of 1 to 3 integers"},
      {"d828 82 818101 8101", "byte 6: dimensions of an array: needed a list of 1 to 3 integers"},
      {"d828 82 8120 8101", "byte 5: dimension 0 of an array: got -1, needed an integer >= 0"},
      {"d828 82 8201f93e00 8101",
       "byte 8: dimension 1 of an array: got 1.5, needed an integer >= 0"},
      {"d828 82 81f97e00 8101", "byte 7: dimension 0 of an array: got nan, needed an integer >= 0"},
      {"d828 82 83 1b001fffffffffffff 1b001fffffffffffff 02 8101",
       "byte 25: numbers of an array with dimensions: got 1, needed the product of the dimensions"},
      {"d828 82 8101 818101",
       "byte 8: numbers of an array with dimensions: got rows, needed a flat array"},
      {"d828 82 8101 6161", "byte 5: an array with dimensions needs [dimensions, numbers]"},
      {"d828 82 8101 a0", "byte 5: an array with dimensions needs [dimensions, numbers]"},
      {"d828 82 8101 81f6", "byte 6: an array with dimensions needs [dimensions, numbers]"},
      {"d841 43010203", "byte 2: got 3 bytes in a typed array, needed a multiple of 2"},
      {"d856 01", "byte 2: got a number behind tag 86, which does not go with it"},
      {"d856 6161", "byte 2: got a text behind tag 86, which does not go with it"},
      {"d856 8101", "byte 2: got an array behind tag 86, which does not go with it"},
      {"d84c 4101", "byte 0: got tag 76, which is not supported"},
      {"d853 50", "byte 0: got tag 83, which is not supported"},
      {"d857 50", "byte 0: got tag 87, which is not supported"},
      {"d858 41", "byte 0: got tag 88, which is not supported"},
      {"dbffffffffffffffff 00", "byte 0: got tag 18446744073709551615, which is not supported"},
  };
  (void)state;
  CHECK(examples);
}

/* Half floats against their definition, all of them. */
static void test_half(void **state) {
  (void)state;
  for (unsigned bits = 0; bits < 0x10000; bits++) {
    double value = typed_array_half((uint16_t)bits);
    unsigned exponent = bits >> 10 & 31, fraction = bits & 1023;
    double sign = bits >> 15 ? -1 : 1;
    double expected = exponent == 0 ? sign * fraction * pow(2, -24)
                                    : sign * (1 + fraction / 1024.0) * pow(2, (int)exponent - 15);
    if (exponent < 31) {
      assert_memory_equal(&value, &expected, sizeof value);
    } else if (fraction == 0) {
      assert_true(value == sign * HUGE_VAL);
    } else {
      assert_true(isnan(value));
    }
  }
}

/* ---- errors ---- */

static void test_errors(void **state) {
  static const struct {
    const char *hex;
    int64_t offset;
    const char *pointer, *text;
  } cases[] = {
      {"", 0, "", "byte 0: truncated: got the end, needed a value"},
      {"00 00", 1, "", "byte 1: got 1 bytes more, needed the end of the body"},
      {"18", 0, "", "byte 0: truncated: the body ends within an item, 1 bytes into it"},
      {"82 01 fb0000", 2, "/1", "byte 2: truncated: the body ends within an item, 3 bytes into it"},
      {"a1 6161", 3, "/a", "byte 3: truncated: got the end, needed a value"},
      {"9bffffffffffffffff", 0, "",
       "byte 0: truncated: an array claims 18446744073709551615 items, 0 bytes follow"},
      {"bb7fffffffffffffff", 0, "",
       "byte 0: truncated: a map claims 9223372036854775807 items, 0 bytes follow"},
      {"5bffffffffffffffff00", 0, "",
       "byte 0: truncated: the body ends within an item, 10 bytes into it"},
      {"7b7fffffffffffffff00", 0, "",
       "byte 0: truncated: the body ends within an item, 10 bytes into it"},
      {"9a00000004010203", 0, "", "byte 0: truncated: an array claims 4 items, 3 bytes follow"},
      {"81 82 01 62c328", 3, "/0/1", "byte 3: got byte 0xC3 in a text, needed UTF-8"},
      {"7f 61c3 61bc ff", 1, "", "byte 1: got byte 0xC3 in a text, needed UTF-8"},
      {"7f 4101 ff", 1, "", "byte 1: got a chunk of the other kind in a string of chunks"},
      {"5f 6161 ff", 1, "", "byte 1: got a chunk of the other kind in a string of chunks"},
      {"7f 01 ff", 1, "", "byte 1: got a number within a string of chunks, needed a chunk"},
      {"7f 7f6161ff ff", 1, "",
       "byte 1: got a string of chunks within a string of chunks, needed a chunk"},
      {"ff", 0, "", "byte 0: got a break, needed a value"},
      {"81ff", 1, "/0", "byte 1: got a break, needed a value"},
      {"bf6161ff", 3, "/a", "byte 3: got a break, needed a value"},
      {"9fd840ff", 3, "/0", "byte 3: got a break, needed a value"},
      {"a1 01 02", 1, "", "byte 1: got a number as a key, needed a text"},
      {"a1 f6 02", 1, "", "byte 1: got null as a key, needed a text"},
      {"a1 80 02", 1, "", "byte 1: got an array as a key, needed a text"},
      {"a1 4161 02", 1, "", "byte 1: got a byte string as a key, needed a text"},
      {"a1 d840 4161 02", 1, "", "byte 1: got a tag as a key, needed a text"},
      {"a1 61 00 02", 1, "/", "byte 1: a key contains a NUL character"},
      {"a2 6161 01 6161 02", 4, "/a", "byte 4: key \"a\" is there twice in an object"},
      {"81 a2 6161 01 7f6161ff 02", 8, "/0/a", "byte 8: key \"a\" is there twice in an object"},
      {"1c", 0, "", "byte 0: got byte 0x1C, which begins no CBOR value"},
      {"82 01 3f", 2, "/1", "byte 2: got byte 0x3F, which begins no CBOR value"},
      {"c6 00", 0, "", "byte 0: got byte 0xC6, which begins no CBOR value"},
  };
  (void)state;
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    doc_error error;
    char *text = decode(cases[k].hex, &wide, &error);
    assert_string_equal(text, cases[k].text);
    assert_string_equal(error.pointer, cases[k].pointer);
    assert_int_equal(error.offset, cases[k].offset);
    assert_false(error.too_large);
    free(text);
  }
}

/* Every proper start of a body is told to be truncated. */
static void test_truncated(void **state) {
  static const char hex[] =
      "a5 6161 8301fa3f800000fb3ff199999999999a 6162 d828828202 02d8565820 0000000000000000"
      "0000000000000000 0000000000000000 0000000000000000 6163 7f61616162ff 6164 9f01f6ff"
      "6165 bf6178d8405f4101ffff";
  size_t size;
  unsigned char *body = bytes_of(hex, &size);
  (void)state;
  for (size_t n = 0; n <= size; n++) {
    unsigned char *start = malloc(n + (n == 0));
    doc_arena *arena;
    doc_error error;
    memcpy(start, body, n);
    bool taken = doc_from_cbor(start, n, &wide, &arena, &error) != NULL;
    assert_int_equal(taken, n == size);
    if (!taken) assert_non_null(strstr(error.text, "truncated"));
    doc_arena_free(&arena);
    free(start);
  }
  free(body);
}

/* ---- limits ---- */

static void check_limit(const char *hex, doc_limits enough, doc_limits less, const char *pointer) {
  doc_error error;
  free(decode(hex, &enough, &error));
  assert_int_equal(error.text[0], '\0');
  free(decode(hex, &less, &error));
  assert_int_not_equal(error.text[0], '\0');
  assert_true(error.too_large);
  assert_string_equal(error.pointer, pointer);
}

static void test_limits(void **state) {
  (void)state;
  check_limit("81818101", (doc_limits){3, 1, 1}, (doc_limits){2, 1, 1}, "/0/0");
  check_limit("a16161a1616200", (doc_limits){2, 3, 1}, (doc_limits){1, 3, 1}, "/a");
  check_limit("07", (doc_limits){0, 1, 1}, (doc_limits){0, 0, 1}, "");
  check_limit("83010203", (doc_limits){1, 1, 3}, (doc_limits){1, 1, 2}, "/2");
  check_limit("d840 43010203", (doc_limits){1, 1, 3}, (doc_limits){1, 1, 2}, "");
  check_limit("83 01 02 6161", (doc_limits){1, 4, 2}, (doc_limits){1, 3, 2}, "/2");
  check_limit("83 8101 8102 80", (doc_limits){2, 4, 2}, (doc_limits){2, 3, 2}, "/2");
  check_limit("d828 82 8102 820102", (doc_limits){2, 1, 3}, (doc_limits){1, 1, 3}, "/0");
}

static void test_hostile(void **state) {
  enum { SIZE = 1000000 };
  static const struct {
    unsigned char first[3], each[4], last[3];
    size_t width;
    bool taken;
  } cases[] = {
      {{0x9F, 0x00, 0x00}, {0x00}, {0x00, 0x00, 0xFF}, 1, true},
      {{0x9F, 0x00, 0x00}, {0x00}, {0x00, 0xF6, 0xFF}, 1, true},
      {{0x9F, 0x80, 0x80}, {0x80}, {0x80, 0x80, 0xFF}, 1, true},
      {{0x9F, 0x81, 0x00}, {0x81, 0x00}, {0xF6, 0xF6, 0xFF}, 2, true},
      {{0xD9, 0xD9, 0xF7}, {0xD9, 0xD9, 0xF7}, {0x80}, 3, false},
      {{0x5F, 0x40, 0x40}, {0x40}, {0x40, 0x40, 0xFF}, 1, false},
      {{0x7F, 0x60, 0x60}, {0x61, 0x61}, {0x60, 0x60, 0xFF}, 2, true},
      {{0x81, 0x81, 0x81}, {0x81}, {0x81, 0x81, 0x81}, 1, false},
      {{0x9F, 0x9F, 0x9F}, {0x9F}, {0x9F, 0x9F, 0x9F}, 1, false},
      {{0xBF, 0x61, 0x61}, {0xBF, 0x61, 0x61}, {0x00, 0xFF, 0xFF}, 3, false},
  };
  doc_limits limits = {100, SIZE + 10, SIZE + 10};
  unsigned char *body = malloc(SIZE);
  (void)state;
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    doc_arena *arena;
    doc_error error;
    memcpy(body, cases[k].first, 3);
    for (size_t at = 3; at + 3 < SIZE; at++) {
      body[at] = cases[k].each[(at - 3) % cases[k].width];
    }
    size_t end = SIZE - 3 - (SIZE - 6) % cases[k].width;
    memcpy(body + end, cases[k].last, 3);
    bool taken = doc_from_cbor(body, end + 3, &limits, &arena, &error) != NULL;
    if (taken != cases[k].taken) fail_msg("case %zu: %s", k, error.text);
    doc_arena_free(&arena);
  }
  free(body);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_appendix_numbers),
      cmocka_unit_test(test_appendix_others),
      cmocka_unit_test(test_appendix_refused),
      cmocka_unit_test(test_typed_arrays),
      cmocka_unit_test(test_shapes),
      cmocka_unit_test(test_shapes_refused),
      cmocka_unit_test(test_half),
      cmocka_unit_test(test_errors),
      cmocka_unit_test(test_truncated),
      cmocka_unit_test(test_limits),
      cmocka_unit_test(test_hostile),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
