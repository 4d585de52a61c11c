#include "child.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/pidfd.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "ipc.h"
#include "sanitizer.h"

static const child empty = {.pidfd = -1, .socket = -1};

void child_environment(int64_t threads) {
  char text[24];
  snprintf(text, sizeof text, "%lld", (long long)threads);
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  setenv("OMP_NUM_THREADS", text, 1);
}

static void limit_memory(int64_t memory) {
  const struct rlimit limit = {(rlim_t)memory, (rlim_t)memory};
  if (!SANITIZED) setrlimit(RLIMIT_AS, &limit);
}

/* A terminal sends its signals to the whole group; only the front stops workers. */
static void set_signals(void) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, NULL);
  signal(SIGINT, SIG_IGN);
  signal(SIGTERM, SIG_IGN);
  signal(SIGPIPE, SIG_DFL);
}

static void keep_only(int socket) {
  if (socket == IPC_SOCKET) {
    fcntl(socket, F_SETFD, 0);
  } else {
    dup2(socket, IPC_SOCKET);
  }
  close_range(IPC_SOCKET + 1, ~0U, 0);
}

/* In the child: becomes the worker. `front` is the parent's pid. */
static _Noreturn void become_worker(int socket, pid_t front, int64_t memory) {
  char *const words[] = {(char[]){"scatterd"}, (char[]){"worker"}, NULL};
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != front) _exit(2); /* it died before the line above */
  set_signals();
  keep_only(socket);
  limit_memory(memory);
  execv("/proc/self/exe", words);
  _exit(2);
}

bool child_start(child *c, int64_t memory) {
  int ends[2];
  *c = empty;
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return false;
  c->socket = ends[0];
  const pid_t front = getpid();
  const pid_t pid = fork();
  if (pid == 0) become_worker(ends[1], front, memory);
  close(ends[1]);
  if (pid > 0) {
    c->pid = pid;
    c->pidfd = pidfd_open(pid, 0);
    if (c->pidfd >= 0 && fcntl(c->socket, F_SETFL, O_NONBLOCK) == 0) return true;
  }
  const int reason = errno;
  siginfo_t how;
  if (pid > 0) child_kill(c);
  child_reap(c, &how);
  errno = reason;
  return false;
}

void child_kill(const child *c) {
  if (c->pid > 0) kill(c->pid, SIGKILL);
}

void child_reap(child *c, siginfo_t *how) {
  if (c->pid > 0) {
    while (waitid(P_PID, (id_t)c->pid, how, WEXITED) != 0 && errno == EINTR) continue;
  }
  if (c->pidfd >= 0) close(c->pidfd);
  if (c->socket >= 0) close(c->socket);
  *c = empty;
}
