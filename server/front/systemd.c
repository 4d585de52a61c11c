#include "systemd.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <time.h>

/* libsystemd sets close-on-exec; non-blocking is ours to set. */
static bool adopt(int fd, fault *why) {
  if (sd_is_socket(fd, AF_UNSPEC, SOCK_STREAM, 1) <= 0) {
    return fault_set(why, "descriptor %d of the service manager is no listening stream socket", fd);
  }
  if (fcntl(fd, F_SETFL, O_NONBLOCK) == 0) return true;
  return fault_set(why, "descriptor %d of the service manager: %s", fd, strerror(errno));
}

bool systemd_socket(int *fd, fault *why) {
  const int count = sd_listen_fds(1);
  *fd = count > 0 ? SD_LISTEN_FDS_START : -1;
  if (count > 1) return fault_set(why, "got %d sockets of the service manager, needs one", count);
  return count <= 0 || adopt(*fd, why);
}

void systemd_ready(void) {
  (void)sd_notify(0, "READY=1");
}

void systemd_reloading(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  (void)sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%lld",
                   (long long)now.tv_sec * 1000000 + now.tv_nsec / 1000);
}

void systemd_stopping(double seconds) {
  (void)sd_notifyf(0, "STOPPING=1\nEXTEND_TIMEOUT_USEC=%.0f", 1e6 * seconds);
}
