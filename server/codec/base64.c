#include "base64.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/* Four letters of up to three bytes. */
static void encode_group(const unsigned char *in, size_t n, char out[4]) {
  const uint32_t bits =
      (uint32_t)in[0] << 16 | (n > 1 ? (uint32_t)in[1] << 8 : 0) | (n > 2 ? (uint32_t)in[2] : 0);
  for (size_t k = 0; k < 4; k++) out[k] = k <= n ? letters[bits >> (18 - 6 * k) & 63] : '=';
}

char *base64_encode(const void *bytes, size_t size, size_t *length) {
  const unsigned char *in = bytes;
  if (size > SIZE_MAX / 2) return NULL;
  *length = (size + 2) / 3 * 4;
  char *text = malloc(*length + 1);
  if (text == NULL) return NULL;
  for (size_t at = 0, to = 0; at < size; at += 3, to += 4) {
    encode_group(in + at, size - at < 3 ? size - at : 3, text + to);
  }
  text[*length] = '\0';
  return text;
}

/* 0 to 63; -1 for no letter. */
static int value_of(char letter) {
  if (letter >= 'A' && letter <= 'Z') return letter - 'A';
  if (letter >= 'a' && letter <= 'z') return letter - 'a' + 26;
  if (letter >= '0' && letter <= '9') return letter - '0' + 52;
  if (letter == '+' || letter == '-') return 62;
  return letter == '/' || letter == '_' ? 63 : -1;
}

/* The letters before the padding, which must be all there is behind; -1 if it is not. */
static long long take_letters(const char *text, size_t length, unsigned char *out) {
  uint32_t bits = 0;
  size_t count = 0, padding = 0, to = 0;
  for (size_t k = 0; k < length; k++) {
    const int value = value_of(text[k]);
    if (strchr(" \t\r\n", text[k]) != NULL && text[k] != '\0') continue;
    if (text[k] == '=') padding++;
    if (text[k] != '=' && (value < 0 || padding > 0)) return -1;
    if (text[k] == '=') continue;
    bits = bits << 6 | (uint32_t)value;
    if (++count % 4 != 1) out[to++] = (unsigned char)(bits >> (6 - 2 * ((count - 1) % 4)));
  }
  const bool fits = padding == 0 || (padding < 3 && (count + padding) % 4 == 0);
  return fits && count % 4 != 1 ? (long long)to : -1;
}

unsigned char *base64_decode(const char *text, size_t length, long long *size) {
  unsigned char *out = malloc(length / 4 * 3 + 4);
  if (out != NULL) *size = take_letters(text, length, out);
  return out;
}
