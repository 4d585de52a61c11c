#include "digest.h"

#include <errno.h>
#include <nettle/hmac.h>
#include <nettle/memops.h>
#include <nettle/sha2.h>
#include <string.h>
#include <unistd.h>

static void show(const uint8_t *bytes, char text[DIGEST_TEXT]) {
  static const char digits[] = "0123456789abcdef";
  for (int k = 0; k < SHA256_DIGEST_SIZE; k++) {
    *text++ = digits[bytes[k] >> 4];
    *text++ = digits[bytes[k] & 15];
  }
  *text = '\0';
}

bool digest_file(const char *label, int fd, size_t size, char text[DIGEST_TEXT]) {
  struct sha256_ctx state;
  uint8_t sum[SHA256_DIGEST_SIZE], bytes[16384];
  sha256_init(&state);
  if (label != NULL) sha256_update(&state, strlen(label) + 1, (const uint8_t *)label);
  for (size_t done = 0; fd >= 0 && done < size;) {
    const size_t wanted = size - done < sizeof bytes ? size - done : sizeof bytes;
    const ssize_t got = pread(fd, bytes, wanted, (off_t)done);
    if (got < 0 && errno == EINTR) continue;
    if (got == 0) errno = EIO;
    if (got <= 0) return false;
    sha256_update(&state, (size_t)got, bytes);
    done += (size_t)got;
  }
  sha256_digest(&state, sizeof sum, sum);
  show(sum, text);
  return true;
}

void digest_bytes(const void *bytes, size_t size, unsigned char sum[DIGEST_BYTES]) {
  struct sha256_ctx state;
  sha256_init(&state);
  sha256_update(&state, size, bytes);
  sha256_digest(&state, DIGEST_BYTES, sum);
}

bool digest_is(const unsigned char a[DIGEST_BYTES], const unsigned char b[DIGEST_BYTES]) {
  return memeql_sec(a, b, DIGEST_BYTES) != 0;
}

void digest_sign(const char *key, const char *head, const void *body, size_t size,
                 unsigned char sum[DIGEST_BYTES]) {
  struct hmac_sha256_ctx state;
  hmac_sha256_set_key(&state, strlen(key), (const uint8_t *)key);
  hmac_sha256_update(&state, strlen(head), (const uint8_t *)head);
  hmac_sha256_update(&state, size, body);
  hmac_sha256_digest(&state, DIGEST_BYTES, sum);
}
