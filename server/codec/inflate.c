/* The only door to zlib and zstd. */
#include "inflate.h"

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include "grow.h"

enum { GZIP_WINDOW = 15 + 16, GZIP_LEVEL = 1, GZIP_MEMORY = 8 };
enum { ZSTD_LEVEL = 1, ZSTD_WINDOW_LOG = 23 };
enum { ROOM_LEAST = 1 << 14 };

/* One body on its way. */
typedef struct {
  const unsigned char *in, *end;
  grow_bytes out;
  size_t limit; /* of the output */
  void *state;  /* of the coder */
  bool ended;   /* a whole member or frame has been read, and nothing of another one */
} work;

/* How a coding is undone. A step moves `in` and fills some of room[size]. */
typedef struct {
  inflate_status (*start)(work *w);
  inflate_status (*step)(work *w, char *room, size_t size);
  void (*stop)(work *w);
} coder;

static size_t input_left(const work *w) {
  return (size_t)(w->end - w->in);
}

/* ---- identity ---- */

static inflate_status plain_start(work *w) {
  (void)w;
  return INFLATE_OK;
}

static inflate_status plain_step(work *w, char *room, size_t size) {
  size_t n = input_left(w) < size ? input_left(w) : size;
  if (n > 0) memcpy(room, w->in, n);
  w->in += n;
  w->out.size += n;
  w->ended = w->in == w->end;
  return INFLATE_OK;
}

static void plain_stop(work *w) {
  (void)w;
}

/* ---- gzip ---- */

static uInt at_most(size_t n) {
  return n > UINT_MAX ? UINT_MAX : (uInt)n;
}

static inflate_status gzip_start(work *w) {
  z_stream *z = calloc(1, sizeof *z);
  if (z == NULL) return INFLATE_MEMORY;
  if (inflateInit2(z, GZIP_WINDOW) != Z_OK) {
    free(z);
    return INFLATE_MEMORY;
  }
  w->state = z;
  return INFLATE_OK;
}

static inflate_status gzip_step(work *w, char *room, size_t size) {
  z_stream *z = w->state;
  z->next_in = (Bytef *)w->in;
  z->avail_in = at_most(input_left(w));
  z->next_out = (Bytef *)room;
  z->avail_out = at_most(size);
  int code = inflate(z, Z_NO_FLUSH);
  w->in = z->next_in;
  w->out.size += (size_t)((char *)z->next_out - room);
  w->ended = code == Z_STREAM_END;
  if (w->ended && w->in < w->end) code = inflateReset(z);
  if (code == Z_MEM_ERROR) return INFLATE_MEMORY;
  return code == Z_OK || code == Z_STREAM_END || code == Z_BUF_ERROR ? INFLATE_OK : INFLATE_BAD;
}

static void gzip_stop(work *w) {
  if (w->state != NULL) inflateEnd(w->state);
  free(w->state);
}

/* ---- zstd ---- */

static inflate_status zstd_start(work *w) {
  ZSTD_DCtx *z = ZSTD_createDCtx();
  if (z == NULL) return INFLATE_MEMORY;
  ZSTD_DCtx_setParameter(z, ZSTD_d_windowLogMax, ZSTD_WINDOW_LOG);
  w->state = z;
  return INFLATE_OK;
}

static inflate_status zstd_status(size_t code) {
  if (!ZSTD_isError(code)) return INFLATE_OK;
  switch (ZSTD_getErrorCode(code)) {
    case ZSTD_error_memory_allocation:
      return INFLATE_MEMORY;
    case ZSTD_error_frameParameter_windowTooLarge:
      return INFLATE_TOO_LARGE;
    default:
      return INFLATE_BAD;
  }
}

static inflate_status zstd_step(work *w, char *room, size_t size) {
  ZSTD_inBuffer in = {w->in, input_left(w), 0};
  ZSTD_outBuffer out = {room, size, 0};
  size_t code = ZSTD_decompressStream(w->state, &out, &in);
  w->in += in.pos;
  w->out.size += out.pos;
  w->ended = code == 0;
  return zstd_status(code);
}

static void zstd_stop(work *w) {
  ZSTD_freeDCtx(w->state);
}

static const coder coders[CODING_COUNT] = {
    [CODING_IDENTITY] = {plain_start, plain_step, plain_stop},
    [CODING_GZIP] = {gzip_start, gzip_step, gzip_stop},
    [CODING_ZSTD] = {zstd_start, zstd_step, zstd_stop},
};

/* ---- undoing a coding ---- */

/* Room for as much again as there is, up to one byte beyond the limit: that byte shows that more
 * comes out than is allowed. */
static char *output_room(work *w, size_t *size) {
  size_t left = w->limit - w->out.size + (w->limit < SIZE_MAX);
  *size = w->out.size < ROOM_LEAST ? ROOM_LEAST : w->out.size;
  if (*size > left) *size = left;
  return grow_room(&w->out, *size);
}

static inflate_status run(work *w, const coder *c) {
  while (w->in < w->end || !w->ended) {
    size_t size, before = w->out.size;
    const unsigned char *in = w->in;
    char *room = output_room(w, &size);
    if (room == NULL) return INFLATE_MEMORY;
    inflate_status status = c->step(w, room, size);
    if (status != INFLATE_OK) return status;
    if (w->out.size > w->limit) return INFLATE_TOO_LARGE;
    bool stuck = w->in == in && w->out.size == before && !w->ended;
    if (stuck) return INFLATE_BAD;
  }
  return INFLATE_OK;
}

inflate_status inflate_bytes(coding from, const void *in, size_t size, size_t limit, void **out,
                             size_t *out_size) {
  const coder *c = &coders[from];
  work w = {.in = in, .end = (const unsigned char *)in + size, .limit = limit};
  *out = NULL;
  *out_size = 0;
  inflate_status status = c->start(&w);
  if (status == INFLATE_OK) {
    status = run(&w, c);
    c->stop(&w);
  }
  if (status == INFLATE_OK && grow_room(&w.out, 1) == NULL) status = INFLATE_MEMORY;
  if (status != INFLATE_OK) {
    free(w.out.data);
    return status;
  }
  *out = w.out.data;
  *out_size = w.out.size;
  return INFLATE_OK;
}

const char *inflate_text(inflate_status status) {
  static const char *const texts[] = {
      [INFLATE_OK] = "fine",
      [INFLATE_BAD] = "the body is not what its Content-Encoding says: damaged or truncated",
      [INFLATE_TOO_LARGE] = "the body unfolds to more than the limit",
      [INFLATE_MEMORY] = "no memory left to unfold the body",
  };
  return texts[status];
}

/* ---- applying a coding ---- */

/* Writes to room[bound] at once; *used is 0 on failure. */
static size_t plain_pack(const void *in, size_t size, void *room, size_t bound) {
  (void)bound;
  if (size > 0) memcpy(room, in, size);
  return size;
}

static size_t plain_bound(size_t size) {
  return size;
}

static size_t gzip_bound(size_t size) {
  return compressBound(size) + 18 - 6; /* header and trailer of gzip instead of zlib's */
}

static size_t gzip_pack(const void *in, size_t size, void *room, size_t bound) {
  z_stream z = {0};
  if (deflateInit2(&z, GZIP_LEVEL, Z_DEFLATED, GZIP_WINDOW, GZIP_MEMORY, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    return 0;
  }
  const unsigned char *end = (const unsigned char *)in + size;
  z.next_in = (Bytef *)in;
  z.next_out = room;
  int code = Z_OK;
  while (code == Z_OK) {
    z.avail_in = at_most((size_t)(end - z.next_in));
    z.avail_out = at_most(bound - (size_t)((char *)z.next_out - (char *)room));
    code = deflate(&z, z.next_in + z.avail_in == end ? Z_FINISH : Z_NO_FLUSH);
  }
  deflateEnd(&z);
  return code == Z_STREAM_END ? (size_t)((char *)z.next_out - (char *)room) : 0;
}

static size_t zstd_pack(const void *in, size_t size, void *room, size_t bound) {
  size_t used = ZSTD_compress(room, bound, in, size, ZSTD_LEVEL);
  return ZSTD_isError(used) ? 0 : used;
}

typedef struct {
  size_t (*bound)(size_t size);
  size_t (*pack)(const void *in, size_t size, void *room, size_t bound);
} packer;

static const packer packers[CODING_COUNT] = {
    [CODING_IDENTITY] = {plain_bound, plain_pack},
    [CODING_GZIP] = {gzip_bound, gzip_pack},
    [CODING_ZSTD] = {ZSTD_compressBound, zstd_pack},
};

inflate_status deflate_bytes(coding to, const void *in, size_t size, void **out, size_t *out_size) {
  size_t bound = packers[to].bound(size);
  void *room = malloc(bound + 1);
  size_t used = room == NULL ? 0 : packers[to].pack(in, size, room, bound);
  bool fine = room != NULL && (used > 0 || to == CODING_IDENTITY);
  if (!fine) free(room);
  void *fitting = fine ? realloc(room, used + 1) : NULL;
  *out = fitting != NULL ? fitting : fine ? room : NULL;
  *out_size = fine ? used : 0;
  return fine ? INFLATE_OK : INFLATE_MEMORY;
}
