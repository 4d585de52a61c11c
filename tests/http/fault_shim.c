/* fault_shim.c - preloaded into a daemon: makes calls of the system fail when a test says so, sets
 * the clock, and kills workers in a phase. faults.py holds the other end.
 *
 * The file $SCATTERD_FAULTS is mapped by the daemon and by all its workers (before they are locked
 * up) and written by the test: one row per kind of call for the front and one for workers. Calls on
 * files count only below $SCATTERD_FAULTS_BELOW, the data directory.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "ipc.h"

/* ---- What the test orders ---- */

/* The order is that of faults.py. */
typedef enum {
  WRITE, /* write, pwrite, sendfile */
  READ,  /* read, pread */
  SYNC,  /* fsync, fdatasync */
  RENAME,
  OPEN,
  TRUNCATE,
  UNLINK,
  MEMFD,
  MAP, /* mmap of a descriptor */
  FORK,
  PAIR, /* socketpair */
  ACCEPT,
  WATCH,  /* epoll_ctl that adds */
  MEMORY, /* malloc and its like; mmap of no descriptor */
  KINDS
} kind;

typedef struct {
  int64_t after; /* calls that go well first */
  int64_t times; /* calls that fail then; -1: all */
  int64_t error; /* their errno; 0: they do half of what they should */
  int64_t hits;  /* how many have failed so far */
} order;

typedef struct {
  order orders[2][KINDS]; /* of the front, of workers */
  double clock;           /* what is added to the time of day (s) */
  int64_t kills;          /* workers that are to die where they tell of `phase` */
  char phase[32];
  int64_t hold; /* an fsync of a file of so many bytes waits; 0: none does */
  int64_t held; /* how many have begun to */
  int64_t free; /* how many of these may go on */
} orders;

static orders idle, *all = &idle;
static int is_worker;
static const char *below = "/nowhere";

__attribute__((constructor)) static void begin(void) {
  const char *path = getenv("SCATTERD_FAULTS");
  char line[32] = "";
  if (path == NULL) return;
  const int fd = open(path, O_RDWR | O_CLOEXEC);
  if (fd < 0) return;
  void *shared = mmap(NULL, sizeof *all, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  FILE *words = fopen("/proc/self/cmdline", "re");
  if (words != NULL) {
    is_worker =
        fread(line, 1, sizeof line - 1, words) > 9 && !strcmp(line + strlen(line) + 1, "worker");
    fclose(words);
  }
  below = getenv("SCATTERD_FAULTS_BELOW");
  if (shared != MAP_FAILED) all = shared;
}

/* Does an order for this kind stand? Cheap: asked at every call. */
static int is_ordered(kind k) {
  return __atomic_load_n(&all->orders[is_worker][k].times, __ATOMIC_RELAXED) != 0;
}

/* Fails now? Then errno is set. */
static int fails(kind k) {
  order *o = &all->orders[is_worker][k];
  if (!is_ordered(k) || __atomic_sub_fetch(&o->after, 1, __ATOMIC_SEQ_CST) >= 0) return 0;
  if (o->times > 0) __atomic_sub_fetch(&o->times, 1, __ATOMIC_SEQ_CST);
  __atomic_add_fetch(&o->hits, 1, __ATOMIC_SEQ_CST);
  errno = (int)o->error;
  return 1;
}

/* ---- Which files ---- */

static int is_below(const char *path) {
  return strncmp(path, below, strlen(below)) == 0;
}

static int file_is_below(int fd) {
  char link[64], path[PATH_MAX];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return 0;
  path[length] = '\0';
  return is_below(path);
}

static int fails_on(kind k, int fd) {
  return is_ordered(k) && file_is_below(fd) && fails(k);
}

static int fails_at(kind k, int at, const char *path) {
  return is_ordered(k) && (*path == '/' ? is_below(path) : file_is_below(at)) && fails(k);
}

/* ---- The calls ---- */

#define NEXT(type, name) ((type)dlsym(RTLD_NEXT, name))

/* What a failing transfer of `size` bytes still does: half, if no error is ordered. */
#define TRANSFER(k, fd, size, half)        \
  if (fails_on(k, fd)) {                   \
    if (errno != 0 || size < 2) return -1; \
    size = half;                           \
  }

typedef ssize_t write_call(int, const void *, size_t);
typedef ssize_t read_call(int, void *, size_t);
typedef ssize_t pwrite_call(int, const void *, size_t, off64_t);
typedef ssize_t pread_call(int, void *, size_t, off64_t);
typedef ssize_t sendfile_call(int, int, off_t *, size_t);

ssize_t write(int fd, const void *bytes, size_t size) {
  TRANSFER(WRITE, fd, size, size / 2)
  return NEXT(write_call *, "write")(fd, bytes, size);
}

ssize_t pwrite64(int fd, const void *bytes, size_t size, off64_t at) {
  TRANSFER(WRITE, fd, size, size / 2)
  return NEXT(pwrite_call *, "pwrite64")(fd, bytes, size, at);
}

ssize_t pwrite(int fd, const void *bytes, size_t size, off_t at) {
  return pwrite64(fd, bytes, size, at);
}

ssize_t sendfile(int to, int from, off_t *at, size_t size) {
  TRANSFER(WRITE, to, size, size / 2)
  return NEXT(sendfile_call *, "sendfile")(to, from, at, size);
}

ssize_t read(int fd, void *bytes, size_t size) {
  TRANSFER(READ, fd, size, size / 2)
  return NEXT(read_call *, "read")(fd, bytes, size);
}

ssize_t pread64(int fd, void *bytes, size_t size, off64_t at) {
  TRANSFER(READ, fd, size, size / 2)
  return NEXT(pread_call *, "pread64")(fd, bytes, size, at);
}

ssize_t pread(int fd, void *bytes, size_t size, off_t at) {
  return pread64(fd, bytes, size, at);
}

/* Stands still as long as the test says so, for which no disk is slow enough. */
static void wait_if_held(int fd) {
  struct stat facts;
  const int64_t least = __atomic_load_n(&all->hold, __ATOMIC_SEQ_CST);
  if (least == 0 || is_worker || fstat(fd, &facts) != 0 || !S_ISREG(facts.st_mode)) return;
  if (facts.st_size < least || !file_is_below(fd)) return;
  const int64_t mine = __atomic_add_fetch(&all->held, 1, __ATOMIC_SEQ_CST);
  while (__atomic_load_n(&all->hold, __ATOMIC_SEQ_CST) != 0 &&
         __atomic_load_n(&all->free, __ATOMIC_SEQ_CST) < mine) {
    usleep(1000);
  }
}

int fsync(int fd) {
  wait_if_held(fd);
  return fails_on(SYNC, fd) ? -1 : NEXT(int (*)(int), "fsync")(fd);
}

int fdatasync(int fd) {
  return fails_on(SYNC, fd) ? -1 : NEXT(int (*)(int), "fdatasync")(fd);
}

int renameat(int from, const char *old, int to, const char *new) {
  if (fails_at(RENAME, to, new)) return -1;
  return NEXT(int (*)(int, const char *, int, const char *), "renameat")(from, old, to, new);
}

int ftruncate64(int fd, off64_t size) {
  return fails_on(TRUNCATE, fd) ? -1 : NEXT(int (*)(int, off64_t), "ftruncate64")(fd, size);
}

int ftruncate(int fd, off_t size) {
  return ftruncate64(fd, size);
}

int unlinkat(int at, const char *path, int flags) {
  if (fails_at(UNLINK, at, path)) return -1;
  return NEXT(int (*)(int, const char *, int), "unlinkat")(at, path, flags);
}

typedef int open_call(int, const char *, int, ...);

static mode_t mode_of(int flags, va_list arguments) {
  const int makes = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  return makes ? va_arg(arguments, mode_t) : 0;
}

#define OPENS(name, at, ...)                     \
  va_list arguments;                             \
  va_start(arguments, flags);                    \
  const mode_t mode = mode_of(flags, arguments); \
  va_end(arguments);                             \
  if (fails_at(OPEN, at, path)) return -1;       \
  return NEXT(open_call *, name)(at, path, flags, mode);

int openat(int at, const char *path, int flags, ...) {
  OPENS("openat", at)
}

int openat64(int at, const char *path, int flags, ...) {
  OPENS("openat64", at)
}

int open(const char *path, int flags, ...) {
  OPENS("openat", AT_FDCWD)
}

int open64(const char *path, int flags, ...) {
  OPENS("openat64", AT_FDCWD)
}

int memfd_create(const char *name, unsigned flags) {
  return fails(MEMFD) ? -1 : NEXT(int (*)(const char *, unsigned), "memfd_create")(name, flags);
}

typedef void *mmap_call(void *, size_t, int, int, int, off_t);

void *mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset) {
  if (fails(fd >= 0 ? MAP : MEMORY)) return MAP_FAILED;
  return NEXT(mmap_call *, "mmap")(at, size, protection, flags, fd, offset);
}

/* ---- Memory ----
 * What glibc's own functions allocate (strdup, asprintf, getdelim, ...) comes by way of these, too.
 * Where AddressSanitizer has replaced malloc its own is called, else that of glibc: both by a name
 * that needs no dlsym, which may allocate itself. */

#define ALLOCATOR(name, parameters, ...)                                        \
  extern void *__interceptor_##name parameters __attribute__((weak));           \
  extern void *__libc_##name parameters;                                        \
  static void *really_##name parameters {                                       \
    if (__interceptor_##name != NULL) return __interceptor_##name(__VA_ARGS__); \
    return __libc_##name(__VA_ARGS__);                                          \
  }                                                                             \
  void *name parameters {                                                       \
    return fails(MEMORY) ? NULL : really_##name(__VA_ARGS__);                   \
  }

ALLOCATOR(malloc, (size_t size), size)
ALLOCATOR(calloc, (size_t count, size_t size), count, size)
ALLOCATOR(realloc, (void *old, size_t size), old, size)
ALLOCATOR(memalign, (size_t border, size_t size), border, size)

void *aligned_alloc(size_t border, size_t size) {
  return memalign(border, size);
}

int posix_memalign(void **place, size_t border, size_t size) {
  const int before = errno;
  void *bytes = memalign(border, size);
  const int error = bytes == NULL ? errno : 0;
  errno = before;
  if (bytes != NULL) *place = bytes;
  return error;
}

/* ---- Processes, sockets ---- */

pid_t fork(void) {
  return fails(FORK) ? -1 : NEXT(pid_t(*)(void), "fork")();
}

int socketpair(int domain, int type, int protocol, int ends[2]) {
  if (fails(PAIR)) return -1;
  return NEXT(int (*)(int, int, int, int *), "socketpair")(domain, type, protocol, ends);
}

int accept4(int fd, struct sockaddr *address, socklen_t *size, int flags) {
  if (fails(ACCEPT)) return -1;
  return NEXT(int (*)(int, struct sockaddr *, socklen_t *, int), "accept4")(fd, address, size,
                                                                            flags);
}

int epoll_ctl(int epoll, int what, int fd, struct epoll_event *event) {
  if (what == EPOLL_CTL_ADD && fails(WATCH)) return -1;
  return NEXT(int (*)(int, int, int, struct epoll_event *), "epoll_ctl")(epoll, what, fd, event);
}

/* ---- The clock ---- */

int clock_gettime(clockid_t clock, struct timespec *t) {
  const int result = NEXT(int (*)(clockid_t, struct timespec *), "clock_gettime")(clock, t);
  if (result == 0 && clock == CLOCK_REALTIME) t->tv_sec += (time_t)all->clock;
  return result;
}

int gettimeofday(struct timeval *restrict t, void *restrict zone) {
  struct timespec now;
  (void)zone;
  clock_gettime(CLOCK_REALTIME, &now);
  *t = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

time_t time(time_t *t) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (t != NULL) *t = now.tv_sec;
  return now.tv_sec;
}

/* ---- Death of a worker ---- */

/* What it says, as faults.py names it: a phase, or the kind of message. */
static const char *word_of(const ipc_news *news) {
  static const char *const words[] = {
      [IPC_READY] = "ready", [IPC_PROGRESS] = "", [IPC_CHECKPOINT] = "checkpoint",
      [IPC_FETCH] = "fetch", [IPC_KEEP] = "keep", [IPC_REPLY] = "reply"};
  return news->kind == IPC_PROGRESS ? news->phase : words[news->kind];
}

static void die_if(const ipc_news *news) {
  if (all->kills == 0 || strcmp(word_of(news), all->phase) != 0) return;
  if (__atomic_fetch_sub(&all->kills, 1, __ATOMIC_SEQ_CST) > 0) raise(SIGKILL);
}

/* Once it has said where it is; before it has replied, and not after: who has the reply may already
 * have ordered the next death. */
ssize_t sendmsg(int fd, const struct msghdr *message, int flags) {
  const ipc_news *news = message->msg_iov->iov_base;
  const int is_news = is_worker && message->msg_iov->iov_len == sizeof *news;
  const int is_reply = is_news && news->kind == IPC_REPLY;
  if (is_reply) die_if(news);
  const ssize_t sent =
      NEXT(ssize_t(*)(int, const struct msghdr *, int), "sendmsg")(fd, message, flags);
  if (is_news && !is_reply) die_if(news);
  return sent;
}
