#include "ipc.h"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* Room for one descriptor as ancillary data, aligned as CMSG_FIRSTHDR needs it; by that, there is
 * room for two. */
typedef union {
  struct cmsghdr align;
  char bytes[CMSG_SPACE(sizeof(int))];
} ancillary;

enum { ROOM = (CMSG_SPACE(sizeof(int)) - CMSG_LEN(0)) / sizeof(int) };

bool ipc_send(int socket, const void *message, size_t size, int fd) {
  struct iovec part = {(void *)message, size};
  struct msghdr header = {.msg_iov = &part, .msg_iovlen = 1};
  ancillary room;
  if (fd >= 0) {
    memset(&room, 0, sizeof room);
    header.msg_control = room.bytes;
    header.msg_controllen = sizeof room.bytes;
    struct cmsghdr *extra = CMSG_FIRSTHDR(&header);
    extra->cmsg_level = SOL_SOCKET;
    extra->cmsg_type = SCM_RIGHTS;
    extra->cmsg_len = CMSG_LEN(sizeof fd);
    memcpy(CMSG_DATA(extra), &fd, sizeof fd);
  }
  ssize_t sent;
  do sent = sendmsg(socket, &header, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent == (ssize_t)size;
}

/* All descriptors that came, which the kernel has opened whether they are wanted or not. */
static int take_descriptors(struct msghdr *header, int fd[ROOM]) {
  const struct cmsghdr *extra = CMSG_FIRSTHDR(header);
  if (extra == NULL || extra->cmsg_level != SOL_SOCKET || extra->cmsg_type != SCM_RIGHTS) return 0;
  const size_t size = extra->cmsg_len - CMSG_LEN(0);
  memcpy(fd, CMSG_DATA(extra), size);
  return (int)(size / sizeof *fd);
}

ipc_result ipc_receive(int socket, void *message, size_t size, int *fd) {
  struct iovec part = {message, size};
  ancillary room;
  struct msghdr header = {.msg_iov = &part,
                          .msg_iovlen = 1,
                          .msg_control = room.bytes,
                          .msg_controllen = sizeof room.bytes};
  ssize_t received;
  do received = recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
  while (received < 0 && errno == EINTR);
  *fd = -1;
  if (received < 0) return errno == EAGAIN ? IPC_NOTHING : IPC_GONE;
  int came[ROOM];
  const int count = take_descriptors(&header, came);
  if (received == (ssize_t)size && count <= 1 &&
      (header.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) == 0) {
    if (count == 1) *fd = came[0];
    return IPC_MESSAGE;
  }
  for (int k = 0; k < count; k++) close(came[k]);
  return IPC_GONE;
}
