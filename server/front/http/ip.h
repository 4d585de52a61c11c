/* ip.h - addresses of clients and listeners: what machine they are of. Test: unit.ip.
 */
#ifndef SCATTERD_IP_H
#define SCATTERD_IP_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/socket.h>

/* An IPv6 address; one of IPv4 is mapped (::ffff:a.b.c.d). */
typedef struct {
  unsigned char bytes[16];
} ip;

/* Of a socket address; false for a Unix socket and anything else. */
bool ip_of(ip *a, const struct sockaddr *from);

/* Of a text: a.b.c.d or an IPv6 address, without brackets. */
bool ip_read(ip *a, const char *text);

bool ip_is_loopback(const ip *a);

/* Are two of one client? Of IPv6 the first 64 bits say so: whoever has one has all below. */
bool ip_is_same_client(const ip *a, const ip *b);

/* As text, "local" for what is no address. */
void ip_show(const struct sockaddr *from, char *room, size_t size);

#endif
