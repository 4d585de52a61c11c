/* A worker for tests of the front: does not solve, but echoes its body, or fails in the way that
 * the body's first word says: "sleep 2", "abort", "exit 3", "memory", "hog", "big 1000000",
 * "problem", "phase half 0.5 2" (reports, then sleeps), "nothing" (a reply of no bytes), "residual
 * 1e-3", "try open" (says what the kernel says to an attempt that a sandbox must refuse), "lie two"
 * (says to the front what no worker says), "wish URL" (wants two values at once), "checkpoints 2"
 * (has 49 states kept, then sleeps), "given URL" (attempts to write to what it is given to read).
 *
 * SIGUSR1 to a worker ends what it sleeps at the moment, so that a test says when (daemon.py:
 * wake).
 *
 * A check finds everything good but "bad"; "needs 1e9 2" (s) is estimated at so many bytes, "call
 * URL" has a subscriber, "batch 3 sleep 1" is three requests "sleep 1 #0", "sleep 1 #1", ... A
 * stored result is what the run would reply; rendering it gives it back.
 */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "answer.h"
#include "ipc.h"
#include "memory_file.h"
#include "problem.h"

/* Until its time has passed or somebody wakes it. */
static void pause_for(double seconds) {
  const struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
  nanosleep(&t, NULL);
}

static void echo(const ask *a, const char *text, reply *r) {
  (void)text;
  r->bytes = malloc(a->size + 1);
  if (r->bytes == NULL) return;
  memcpy(r->bytes, a->body, a->size);
  r->size = a->size;
}

static void do_sleep(const ask *a, const char *text, reply *r) {
  pause_for(atof(text));
  echo(a, text, r);
}

static void do_abort(const ask *a, const char *text, reply *r) {
  (void)a, (void)text, (void)r;
  abort();
}

static void do_exit(const ask *a, const char *text, reply *r) {
  (void)a, (void)r;
  _exit(atoi(text));
}

/* What the library does when an allocation fails: gives up, without bytes. */
static void do_memory(const ask *a, const char *text, reply *r) {
  (void)a, (void)text, (void)r;
}

/* Takes memory, really, until there is none. */
static void do_hog(const ask *a, const char *text, reply *r) {
  const size_t step = (size_t)16 << 20;
  void **first = NULL;
  (void)a, (void)text, (void)r;
  for (void **block; (block = malloc(step)) != NULL; first = block) {
    memset(block, 1, step);
    *block = first;
  }
  while (first != NULL) {
    void **next = *first;
    free(first);
    first = next;
  }
}

static void do_big(const ask *a, const char *text, reply *r) {
  (void)a;
  r->size = (size_t)atoll(text);
  r->bytes = malloc(r->size);
  if (r->bytes != NULL) memset(r->bytes, 'x', r->size);
}

static void do_problem(const ask *a, const char *text, reply *r) {
  problem p;
  (void)a, (void)text;
  problem_begin(&p, 422, "the matrix is singular");
  problem_add(&p, "/inputs/boundary", "got no dirichlet entry, needs one");
  r->status = p.status;
  snprintf(r->type, sizeof r->type, "%s", media_type(MEDIA_PROBLEM));
  snprintf(r->detail, sizeof r->detail, "%.199s", p.detail);
  r->bytes = problem_bytes(&p, &r->size);
}

/* "needs 1e9 0.5": sleeps so long. */
static void do_needs(const ask *a, const char *text, reply *r) {
  double seconds = 0;
  (void)sscanf(text, "%*s %lf", &seconds);
  pause_for(seconds);
  echo(a, text, r);
}

static void do_phase(const ask *a, const char *text, reply *r) {
  char phase[32];
  double fraction, seconds;
  if (sscanf(text, "%31s %lf %lf", phase, &fraction, &seconds) != 3) return;
  a->calls.report(a->calls.context, "before", 0);
  a->calls.report(a->calls.context, phase, fraction);
  pause_for(seconds);
  echo(a, text, r);
}

static void do_residual(const ask *a, const char *text, reply *r) {
  a->calls.residual(a->calls.context, atof(text));
  a->calls.report(a->calls.context, "solve", 0.75);
  pause_for(600);
  echo(a, text, r);
}

static void do_nothing(const ask *a, const char *text, reply *r) {
  (void)a, (void)text;
  r->bytes = malloc(1);
}

/* Attempts: a descriptor or process id, or -1 with errno. */

static int try_open(void) {
  return open("/etc/hostname", O_RDONLY);
}
static int try_create(void) {
  return open("/tmp/scatterd-sandbox", O_WRONLY | O_CREAT, 0600);
}
static int try_stat(void) {
  return access("/etc/passwd", R_OK);
}
static int try_socket(void) {
  return socket(AF_INET, SOCK_STREAM, 0);
}
static int try_local(void) {
  return socket(AF_UNIX, SOCK_STREAM, 0);
}
static int try_kill(void) {
  return kill(getppid(), 0);
}
static int try_signal(void) { /* what would end the front, if it arrived */
  return (int)syscall(SYS_tgkill, getppid(), getppid(), SIGKILL);
}
static int try_owner(void) {
  return fcntl(IPC_SOCKET, F_SETOWN, getppid());
}
static int try_blocking(void) {
  return fcntl(STDERR_FILENO, F_SETFL, O_NONBLOCK);
}
static int try_affinity(void) {
  const cpu_set_t first = {{1}};
  return sched_setaffinity(getppid(), sizeof first, &first);
}
static int try_code(void) {
  void *page = mmap(NULL, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return page == MAP_FAILED ? -1 : 0;
}
/* A file of its own that grows above memory-bytes. */
static int try_grow(void) {
  const int fd = memfd_create("grow", MFD_CLOEXEC);
  const int result = fd < 0 ? fd : ftruncate(fd, (off_t)1 << 40);
  const int reason = errno;
  if (fd >= 0) close(fd);
  errno = reason;
  return result;
}
static int try_limit(void) {
  return setrlimit(RLIMIT_AS, &(struct rlimit){RLIM_INFINITY, RLIM_INFINITY});
}
static int try_trace(void) {
  return (int)ptrace(PTRACE_TRACEME, 0, NULL, NULL);
}

static int try_process(void) {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  return (int)child;
}

static int try_program(void) {
  return execl("/bin/true", "true", (char *)NULL);
}

static void *return_seven(void *number) {
  *(int *)number = 7;
  return NULL;
}

/* This one must succeed: a solver may use threads. */
static int try_thread(void) {
  pthread_t other;
  int number = -1;
  errno = pthread_create(&other, NULL, return_seven, &number);
  if (errno != 0) return -1;
  pthread_join(other, NULL);
  return number;
}

static const struct {
  const char *word;
  int (*run)(void);
} attempts[] = {{"open", try_open},         {"create", try_create}, {"stat", try_stat},
                {"socket", try_socket},     {"local", try_local},   {"kill", try_kill},
                {"limit", try_limit},       {"trace", try_trace},   {"process", try_process},
                {"program", try_program},   {"thread", try_thread}, {"signal", try_signal},
                {"owner", try_owner},       {"code", try_code},     {"blocking", try_blocking},
                {"affinity", try_affinity}, {"grow", try_grow}};

static void do_try(const ask *a, const char *text, reply *r) {
  (void)a;
  while (*text == ' ') text++;
  for (size_t k = 0; k < sizeof attempts / sizeof *attempts; k++) {
    if (strcmp(attempts[k].word, text) != 0) continue;
    errno = 0;
    const int result = attempts[k].run();
    const int length = asprintf((char **)&r->bytes, "%s", result < 0 ? strerror(errno) : "done");
    r->size = length > 0 ? (size_t)length : 0;
  }
}

/* ---- Lies: what only a worker says that somebody has taken over ---- */

static int filled(const char *name) {
  const int fd = memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0 || write(fd, "lie", 3) != 3) abort();
  return fd;
}

static void say(ipc_news news, int fd) {
  (void)ipc_send(IPC_SOCKET, &news, sizeof news, fd);
}

static void lie_unsealed(void) { /* to be cut short once it is mapped */
  say((ipc_news){.kind = IPC_REPLY, .status = 200, .size = 3}, filled("unsealed"));
}
static void lie_short(void) {
  const int fd = filled("short");
  (void)memory_file_seal(fd);
  say((ipc_news){.kind = IPC_REPLY, .status = 200, .size = 4}, fd);
}
static void lie_stream(void) {
  say((ipc_news){.kind = IPC_REPLY, .status = 200}, STDERR_FILENO);
}
static void lie_status(void) {
  const int fd = filled("status");
  (void)memory_file_seal(fd);
  say((ipc_news){.kind = IPC_REPLY, .status = 99999, .size = 3}, fd);
}
static void lie_page(void) { /* a page that would be served under /data */
  const int fd = filled("page");
  (void)memory_file_seal(fd);
  say((ipc_news){.kind = IPC_KEEP, .size = 3, .type = "text/html"}, fd);
}
static void lie_ready(void) {
  say((ipc_news){.kind = IPC_READY}, -1);
}
static void lie_kind(void) {
  say((ipc_news){.kind = (ipc_kind)77}, -1);
}
static void lie_piece(void) {
  (void)ipc_send(IPC_SOCKET, "piece", 5, -1);
}

/* Two descriptors where there may be one. */
static void lie_two(void) {
  const ipc_news news = {.kind = IPC_PROGRESS};
  const int two[2] = {filled("first"), filled("second")};
  union {
    struct cmsghdr align;
    char bytes[CMSG_SPACE(sizeof two)];
  } room;
  struct iovec part = {(void *)&news, sizeof news};
  struct msghdr header = {.msg_iov = &part,
                          .msg_iovlen = 1,
                          .msg_control = room.bytes,
                          .msg_controllen = sizeof room.bytes};
  memset(&room, 0, sizeof room);
  struct cmsghdr *extra = CMSG_FIRSTHDR(&header);
  extra->cmsg_level = SOL_SOCKET;
  extra->cmsg_type = SCM_RIGHTS;
  extra->cmsg_len = CMSG_LEN(sizeof two);
  memcpy(CMSG_DATA(extra), two, sizeof two);
  (void)sendmsg(IPC_SOCKET, &header, MSG_NOSIGNAL);
}

/* Talks without end. */
static void lie_flood(void) {
  const ipc_news news = {.kind = IPC_PROGRESS, .phase = "flood", .fraction = NAN};
  while (ipc_send(IPC_SOCKET, &news, sizeof news, -1)) continue;
}

/* "wish URL": wants it twice without waiting for the first. */
static void do_wish(const ask *a, const char *text, reply *r) {
  ipc_news news = {.kind = IPC_FETCH};
  (void)a, (void)r;
  snprintf(news.href, sizeof news.href, "%s", text + strspn(text, " "));
  say(news, -1);
  say(news, -1);
  pause_for(60);
}

/* "given URL": fetches it and says what the kernel says to an attempt to write there. */
static void do_given(const ask *a, const char *text, reply *r) {
  ipc_news news = {.kind = IPC_FETCH};
  ipc_given given;
  int fd = -1;
  (void)a;
  snprintf(news.href, sizeof news.href, "%s", text + strspn(text, " "));
  say(news, -1);
  if (ipc_receive(IPC_SOCKET, &given, sizeof given, &fd) != IPC_MESSAGE || fd < 0) return;
  const ssize_t written = write(fd, "x", 1);
  const int length = asprintf((char **)&r->bytes, "%s", written < 0 ? strerror(errno) : "done");
  r->size = length > 0 ? (size_t)length : 0;
  close(fd);
}

/* Many checkpoints at once, each longer than the one before. */
static void do_checkpoints(const ask *a, const char *text, reply *r) {
  char bytes[50] = "";
  for (size_t k = 1; k < sizeof bytes; k++) a->calls.checkpoint(a->calls.context, bytes, k);
  pause_for(atof(text));
  echo(a, text, r);
}

static const struct {
  const char *word;
  void (*tell)(void);
} lies[] = {{"unsealed", lie_unsealed}, {"short", lie_short}, {"stream", lie_stream},
            {"status", lie_status},     {"page", lie_page},   {"ready", lie_ready},
            {"kind", lie_kind},         {"piece", lie_piece}, {"two", lie_two},
            {"flood", lie_flood}};

/* The front kills it for that, or it sleeps until its time is over. */
static void do_lie(const ask *a, const char *text, reply *r) {
  (void)a, (void)r;
  while (*text == ' ') text++;
  for (size_t k = 0; k < sizeof lies / sizeof *lies; k++) {
    if (strcmp(lies[k].word, text) == 0) lies[k].tell();
  }
  pause_for(60);
}

static const struct {
  const char *word;
  void (*run)(const ask *a, const char *text, reply *r);
} words[] = {{"sleep", do_sleep},       {"abort", do_abort},
             {"exit", do_exit},         {"memory", do_memory},
             {"hog", do_hog},           {"big", do_big},
             {"problem", do_problem},   {"phase", do_phase},
             {"nothing", do_nothing},   {"try", do_try},
             {"fail", do_problem},      {"needs", do_needs},
             {"residual", do_residual}, {"lie", do_lie},
             {"wish", do_wish},         {"checkpoints", do_checkpoints},
             {"given", do_given}};

/* ---- Checks ---- */

static void add_frame(reply *r, ipc_frame_kind kind, const char *process, const char *text) {
  ipc_frame frame = {.kind = kind, .size = (int64_t)strlen(text)};
  snprintf(frame.process, sizeof frame.process, "%s", process);
  char *more = realloc(r->bytes, r->size + sizeof frame + strlen(text));
  if (more == NULL) abort();
  memcpy(more + r->size, &frame, sizeof frame);
  memcpy(more + r->size + sizeof frame, text, strlen(text));
  r->bytes = more;
  r->size += sizeof frame + strlen(text);
}

static void check(const ask *a, const char *text, reply *r) {
  char word[256] = "", child[300];
  int count = 0, used = 0;
  r->bytes = malloc(1);
  if (sscanf(text, "needs %255s", word) == 1) r->memory_bytes = (int64_t)atof(word);
  if (sscanf(text, "call %255s", word) == 1) add_frame(r, IPC_FRAME_SUCCESS, "", word);
  if (sscanf(text, "fail %255s", word) == 1) add_frame(r, IPC_FRAME_FAILED, "", word);
  if (sscanf(text, "batch %d %n", &count, &used) == 1) {
    for (int k = 0; k < count; k++) {
      snprintf(child, sizeof child, "%s #%d", text + used, k);
      add_frame(r, IPC_FRAME_CHILD, "solve", child);
    }
  }
  if (strncmp(text, "bad", 3) == 0) do_problem(a, text, r);
}

static int is_worker(void) {
  char name[16] = "";
  FILE *line = fopen("/proc/self/cmdline", "re");
  if (line == NULL) return 0;
  const size_t size = fread(name, 1, sizeof name, line);
  fclose(line);
  return size == sizeof name && memcmp(name, "scatterd\0worker", sizeof name) == 0;
}

static void wake(int signal_number) {
  (void)signal_number; /* that it came is enough */
}

/* With SCATTERD_STUB_DIES in the environment a worker dies before it can serve. Nobody dies of
 * being woken: the front ignores it, and so does whoever becomes a worker until it gets here. */
__attribute__((constructor)) static void begin(void) {
  const int works = is_worker();
  if (works && getenv("SCATTERD_STUB_DIES") != NULL) _exit(3);
  const struct sigaction action = {.sa_handler = works ? wake : SIG_IGN, .sa_flags = SA_RESTART};
  sigaction(SIGUSR1, &action, NULL);
}

void answer_prepare(void) {}

/* It never runs by ranks. */
by_ranks *answer_ranks_new(void) {
  return NULL;
}

int answer_ranks_place(const by_ranks *r) {
  (void)r;
  return 0;
}

answer_role answer_ranks_role(const by_ranks *r) {
  (void)r;
  return ANSWER_REPLIES;
}

void answer_ranks_free(by_ranks **r) {
  *r = NULL;
}

void answer(const ask *a, reply *r) {
  char text[256];
  const size_t length = a->size < sizeof text - 1 ? a->size : sizeof text - 1;
  memcpy(text, a->body, length);
  text[length] = '\0';
  r->status = 200;
  r->coding = a->content_coding;
  const media forms[] = {MEDIA_JSON, MEDIA_CBOR};
  const media form = media_pick(&a->accept, forms, 2);
  snprintf(r->type, sizeof r->type, "%s", media_type(form == MEDIA_COUNT ? MEDIA_JSON : form));
  const size_t word = strcspn(text, " ");
  if (a->work == IPC_CHECK) {
    check(a, text, r);
    return;
  }
  if (a->work == IPC_RENDER) {
    echo(a, text, r);
    return;
  }
  for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
    if (strlen(words[k].word) != word || strncmp(words[k].word, text, word) != 0) continue;
    words[k].run(a, text + word, r);
    return;
  }
  echo(a, text, r);
}
