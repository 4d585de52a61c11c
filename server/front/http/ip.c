#include "ip.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>

static const unsigned char mapped[12] = {[10] = 0xff, [11] = 0xff};

static void map(ip *a, const struct in_addr *four) {
  memcpy(a->bytes, mapped, sizeof mapped);
  memcpy(a->bytes + sizeof mapped, four, 4);
}

bool ip_of(ip *a, const struct sockaddr *from) {
  if (from->sa_family == AF_INET) {
    map(a, &((const struct sockaddr_in *)from)->sin_addr);
  } else if (from->sa_family == AF_INET6) {
    memcpy(a->bytes, &((const struct sockaddr_in6 *)from)->sin6_addr, sizeof a->bytes);
  } else {
    return false;
  }
  return true;
}

bool ip_read(ip *a, const char *text) {
  struct in_addr four;
  if (inet_pton(AF_INET, text, &four) != 1) return inet_pton(AF_INET6, text, a->bytes) == 1;
  map(a, &four);
  return true;
}

static bool is_four(const ip *a) {
  return memcmp(a->bytes, mapped, sizeof mapped) == 0;
}

bool ip_is_loopback(const ip *a) {
  static const ip one = {.bytes = {[15] = 1}};
  return is_four(a) ? a->bytes[12] == 127 : memcmp(a, &one, sizeof one) == 0;
}

bool ip_is_same_client(const ip *a, const ip *b) {
  return memcmp(a->bytes, b->bytes, is_four(a) ? 16 : 8) == 0;
}

void ip_show(const struct sockaddr *from, char *room, size_t size) {
  const void *number = from->sa_family == AF_INET
                           ? (const void *)&((const struct sockaddr_in *)from)->sin_addr
                           : (const void *)&((const struct sockaddr_in6 *)from)->sin6_addr;
  snprintf(room, size, "local");
  if (from->sa_family == AF_INET || from->sa_family == AF_INET6) {
    inet_ntop(from->sa_family, number, room, (socklen_t)size);
  }
}
