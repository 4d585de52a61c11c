#include "listener.h"

#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "ip.h"
#include "systemd.h"

static const int backlog = 1024;

static bool start(listener *l, const struct sockaddr *address, socklen_t size, const char *text,
                  fault *why) {
  const int on = 1;
  l->fd = socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (l->fd >= 0 && address->sa_family != AF_UNIX) {
    setsockopt(l->fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  }
  if (l->fd >= 0 && bind(l->fd, address, size) == 0 && listen(l->fd, backlog) == 0) return true;
  fault_set(why, "cannot listen on %.200s: %s", text, strerror(errno));
  if (l->fd >= 0) close(l->fd);
  l->fd = -1;
  return false;
}

/* Removes a socket file that nobody listens on. */
static void remove_stale(const struct sockaddr_un *address) {
  struct stat facts;
  if (stat(address->sun_path, &facts) != 0 || !S_ISSOCK(facts.st_mode)) return;
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return;
  const int result = connect(fd, (const struct sockaddr *)address, sizeof *address);
  if (result != 0 && errno == ECONNREFUSED) unlink(address->sun_path);
  close(fd);
}

static void name_unix(listener *l, const char *path) {
  snprintf(l->address, sizeof l->address, "unix:%s", path);
  snprintf(l->host, sizeof l->host, "localhost");
  l->is_local = l->is_unix = true;
}

static bool open_unix(listener *l, const char *path, fault *why) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  if (*path == '\0' || strlen(path) >= sizeof address.sun_path) {
    return fault_set(why, "listen: got a socket path of %zu characters, needs 1 to %zu",
                     strlen(path), sizeof address.sun_path - 1);
  }
  memcpy(address.sun_path, path, strlen(path) + 1);
  remove_stale(&address);
  if (!start(l, (struct sockaddr *)&address, sizeof address, path, why)) return false;
  memcpy(l->path, address.sun_path, sizeof l->path);
  name_unix(l, path);
  return true;
}

/* Splits ADDR:PORT or [ADDR]:PORT. */
static bool split(const char *text, char *host, size_t room, const char **port) {
  const char *colon = strrchr(text, ':');
  if (colon == NULL || colon[1] == '\0' || colon == text) return false;
  const bool bracketed = *text == '[' && colon[-1] == ']';
  const char *from = text + bracketed, *to = colon - bracketed;
  if (from >= to || (size_t)(to - from) >= room) return false;
  snprintf(host, room, "%.*s", (int)(to - from), from);
  *port = colon + 1;
  return bracketed || strchr(host, ':') == NULL;
}

/* Writes where the socket really listens. */
static void name_address(listener *l) {
  struct sockaddr_storage from = {.ss_family = AF_UNSPEC};
  socklen_t size = sizeof from;
  char host[256] = "", port[16] = "";
  getsockname(l->fd, (struct sockaddr *)&from, &size);
  if (from.ss_family == AF_UNIX) {
    name_unix(l, ((const struct sockaddr_un *)&from)->sun_path);
    return;
  }
  ip found;
  l->is_local = ip_of(&found, (struct sockaddr *)&from) && ip_is_loopback(&found);
  getnameinfo((struct sockaddr *)&from, size, host, sizeof host, port, sizeof port,
              NI_NUMERICHOST | NI_NUMERICSERV);
  const bool six = from.ss_family == AF_INET6;
  snprintf(l->address, sizeof l->address, six ? "[%s]:%s" : "%s:%s", host, port);
  memcpy(l->host, l->address, sizeof l->host);
}

static bool open_tcp(listener *l, const char *text, fault *why) {
  char host[256];
  const char *port;
  if (!split(text, host, sizeof host, &port)) {
    return fault_set(why, "listen: got \"%.200s\", needs ADDR:PORT, [ADDR]:PORT or unix:PATH",
                     text);
  }
  const struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE};
  struct addrinfo *found;
  const int error = getaddrinfo(host, port, &hints, &found);
  if (error != 0) return fault_set(why, "listen: %.200s: %s", text, gai_strerror(error));
  const bool good = start(l, found->ai_addr, found->ai_addrlen, text, why);
  freeaddrinfo(found);
  if (good) name_address(l);
  return good;
}

bool listener_open(listener *l, const char *text, fault *why) {
  *l = (listener){.fd = -1};
  if (!systemd_socket(&l->fd, why)) return false;
  if (l->fd >= 0) {
    name_address(l);
    return true;
  }
  if (strncmp(text, "unix:", 5) == 0) return open_unix(l, text + 5, why);
  return open_tcp(l, text, why);
}

void listener_close(listener *l) {
  if (l->fd >= 0) close(l->fd);
  if (*l->path != '\0') unlink(l->path);
  *l = (listener){.fd = -1};
}
