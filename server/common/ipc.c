#include "ipc.h"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* Room for one descriptor as ancillary data, aligned as CMSG_FIRSTHDR needs it. */
typedef union {
  struct cmsghdr align;
  char bytes[CMSG_SPACE(sizeof(int))];
} ancillary;

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

static int descriptor_of(struct msghdr *header) {
  int fd = -1;
  const struct cmsghdr *extra = CMSG_FIRSTHDR(header);
  if (extra != NULL && extra->cmsg_level == SOL_SOCKET && extra->cmsg_type == SCM_RIGHTS) {
    memcpy(&fd, CMSG_DATA(extra), sizeof fd);
  }
  return fd;
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
  *fd = descriptor_of(&header);
  if (received == (ssize_t)size && (header.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) == 0) {
    return IPC_MESSAGE;
  }
  if (*fd >= 0) close(*fd);
  *fd = -1;
  return IPC_GONE;
}
