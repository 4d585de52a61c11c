#include "command.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/pidfd.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "memory_file.h"

struct command {
  loop *loop;
  pid_t pid;
  int pidfd, kept; /* -1: its output goes elsewhere */
  loop_source exited;
  void (*ended)(void *self, const command_end *end);
  void *self;
};

static void set_signals(void) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, NULL);
  signal(SIGPIPE, SIG_DFL);
}

/* In the child. `front` is the parent's pid. */
static _Noreturn void become(const char *const argv[], int output, pid_t front) {
  const int null = open("/dev/null", O_RDONLY);
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != front) _exit(127); /* it died before the line above */
  set_signals();
  dup2(null, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  close_range(STDERR_FILENO + 1, ~0U, 0);
  execvp(argv[0], (char *const *)(uintptr_t)argv);
  fprintf(stderr, "%s: %s\n", argv[0], strerror(errno));
  _exit(127);
}

static void release(command *c) {
  if (c->pidfd >= 0) close(c->pidfd);
  if (c->kept >= 0) close(c->kept);
  free(c);
}

static void read_output(const command *c, command_end *end) {
  const ssize_t size = c->kept >= 0 ? pread(c->kept, end->output, sizeof end->output - 1, 0) : 0;
  end->output[size > 0 ? size : 0] = '\0';
}

static void reap(const command *c, siginfo_t *how) {
  while (waitid(P_PID, (id_t)c->pid, how, WEXITED) != 0 && errno == EINTR) continue;
}

static void on_exited(void *self, uint32_t events) {
  command *c = self;
  siginfo_t how = {0};
  command_end end;
  (void)events;
  loop_forget(c->loop, c->pidfd, &c->exited);
  reap(c, &how);
  kill(-c->pid, SIGKILL); /* what it may have left */
  end.code = how.si_code == CLD_EXITED ? how.si_status : -1;
  read_output(c, &end);
  void (*const ended)(void *, const command_end *) = c->ended;
  void *const who = c->self;
  release(c);
  ended(who, &end);
}

static bool watch(command *c) {
  c->pidfd = pidfd_open(c->pid, 0);
  c->exited = (loop_source){on_exited, c};
  return c->pidfd >= 0 && loop_watch(c->loop, c->pidfd, EPOLLIN, &c->exited);
}

command *command_start(loop *l, const char *const argv[], int output,
                       void (*ended)(void *self, const command_end *end), void *self) {
  command *c = malloc(sizeof *c);
  if (c == NULL) return NULL;
  *c = (command){.loop = l, .pidfd = -1, .kept = -1, .ended = ended, .self = self};
  if (output < 0) c->kept = memory_file("output");
  const pid_t front = getpid();
  c->pid = fork();
  if (c->pid == 0) become(argv, output >= 0 ? output : c->kept, front);
  if (c->pid > 0) setpgid(c->pid, c->pid);
  if (c->pid > 0 && watch(c)) return c;
  const int reason = errno;
  if (c->pid > 0) {
    kill(c->pid, SIGKILL);
    reap(c, &(siginfo_t){0});
  }
  release(c);
  errno = reason;
  return NULL;
}

void command_signal(const command *c, int signal) {
  kill(-c->pid, signal);
}

void command_kill(command **c) {
  if (*c == NULL) return;
  loop_forget((*c)->loop, (*c)->pidfd, &(*c)->exited);
  command_signal(*c, SIGKILL);
  reap(*c, &(siginfo_t){0});
  release(*c);
  *c = NULL;
}

int command_words(char *line, const char *words[], int room) {
  int count = 0;
  char *rest = NULL;
  for (char *word = strtok_r(line, " \t", &rest); word != NULL && count < room;
       word = strtok_r(NULL, " \t", &rest)) {
    words[count++] = word;
  }
  return count;
}
