#include "negotiate.h"

#include "http.h"
#include "inflate.h"
#include "media.h"

int negotiate(exchange *x, const char *const *offers, int count) {
  char room[512];
  const char *accept = http_field(x, "Accept", room, sizeof room);
  const int chosen = media_choose(accept, offers, count);
  exchange_add(x, "Vary", "Accept");
  if (chosen < 0) {
    exchange_refuse(x, 406, "Accept: got \"%.100s\", needs %s%s%s", accept, offers[0],
                    count > 1 ? " or " : "", count > 1 ? offers[1] : "");
  }
  return chosen;
}

bool negotiate_json(exchange *x) {
  const char *const offers[] = {media_type(MEDIA_JSON)};
  return negotiate(x, offers, 1) == 0;
}

void negotiate_coding(exchange *x) {
  enum { WORTH = 1024 }; /* bytes: what fits into one packet gains nothing */
  char room[512];
  const char *wanted = http_field(x, "Accept-Encoding", room, sizeof room);
  exchange_reply *r = &x->reply;
  coding how;
  void *packed;
  size_t size;
  if (r->status != 200) return;
  exchange_add(x, "Vary", "Accept-Encoding");
  if (r->size < WORTH || !coding_choose(wanted, &how) || how == CODING_IDENTITY) return;
  if (deflate_bytes(how, r->bytes, r->size, &packed, &size) != INFLATE_OK) return; /* as it is */
  exchange_pack(x, how, packed, size);
}
