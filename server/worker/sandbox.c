#include "sandbox.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "sanitizer.h"

/* Descriptors of a worker: its standard streams, its socket, a body, a reply, and a few values that
 * a body names by reference. */
static const rlim_t most_descriptors = 64;

/* A call that this architecture lacks has a number that no rule matches. */
static const int allowed[] = {
    /* memory */
    SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise), SCMP_SYS(memfd_create),
    SCMP_SYS(membarrier),
    /* descriptors at hand */
    SCMP_SYS(read), SCMP_SYS(readv), SCMP_SYS(pread64), SCMP_SYS(write), SCMP_SYS(writev),
    SCMP_SYS(pwrite64), SCMP_SYS(lseek), SCMP_SYS(close), SCMP_SYS(fstat), SCMP_SYS(ftruncate),
    SCMP_SYS(fallocate), SCMP_SYS(sendmsg), SCMP_SYS(recvmsg), SCMP_SYS(sendto), SCMP_SYS(recvfrom),
    SCMP_SYS(poll), SCMP_SYS(ppoll),
    /* threads and signals of its own */
    SCMP_SYS(futex), SCMP_SYS(set_robust_list), SCMP_SYS(rseq), SCMP_SYS(set_tid_address),
    SCMP_SYS(gettid), SCMP_SYS(getpid), SCMP_SYS(sched_yield), SCMP_SYS(sched_getaffinity),
    SCMP_SYS(getcpu), SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sigaltstack), SCMP_SYS(restart_syscall), SCMP_SYS(exit), SCMP_SYS(exit_group),
    /* time, chance and what the process may know of itself */
    SCMP_SYS(clock_gettime), SCMP_SYS(clock_getres), SCMP_SYS(gettimeofday), SCMP_SYS(time),
    SCMP_SYS(nanosleep), SCMP_SYS(clock_nanosleep), SCMP_SYS(getrandom), SCMP_SYS(getrusage),
    SCMP_SYS(times), SCMP_SYS(sysinfo), SCMP_SYS(uname)};

enum { CALLS = sizeof allowed / sizeof *allowed };

static bool fail(fault *why, const char *layer, int error) {
  return fault_set(why, "%s: %s", layer, strerror(error));
}

static void limit(int what, rlim_t most) {
  const struct rlimit both = {most, most};
  setrlimit(what, &both);
}

/* No rule is added, so every access that landlock handles is refused. A kernel without it is no
 * failure: seccomp refuses the same calls. */
static void forget_files(void) {
  const struct landlock_ruleset_attr all = {
      .handled_access_fs = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_WRITE_FILE |
                           LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR |
                           LANDLOCK_ACCESS_FS_REMOVE_DIR | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                           LANDLOCK_ACCESS_FS_MAKE_CHAR | LANDLOCK_ACCESS_FS_MAKE_DIR |
                           LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_MAKE_SOCK |
                           LANDLOCK_ACCESS_FS_MAKE_FIFO | LANDLOCK_ACCESS_FS_MAKE_BLOCK |
                           LANDLOCK_ACCESS_FS_MAKE_SYM};
  const int rules = (int)syscall(SYS_landlock_create_ruleset, &all, sizeof all, 0);
  if (rules < 0) return;
  (void)syscall(SYS_landlock_restrict_self, rules, 0);
  close(rules);
}

static int allow_if(scmp_filter_ctx filter, int call, struct scmp_arg_cmp condition) {
  return seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 1, condition);
}

/* What a descriptor is and whether it may change. Not: who is signalled when something comes
 * (F_SETOWN, F_SETSIG), which would be a way to kill the front; nor the state of what is shared
 * with it (F_SETFL). */
static int add_fcntl(scmp_filter_ctx filter) {
  static const int harmless[] = {F_GETFD, F_SETFD, F_GETFL, F_ADD_SEALS, F_GET_SEALS};
  int error = 0;
  for (size_t k = 0; k < sizeof harmless / sizeof *harmless && error == 0; k++) {
    error = allow_if(filter, SCMP_SYS(fcntl), SCMP_A1_32(SCMP_CMP_EQ, (unsigned)harmless[k]));
  }
  return error;
}

/* Memory is for data: what a body brings in is never run. */
static int add_memory(scmp_filter_ctx filter) {
  const struct scmp_arg_cmp is_data = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0);
  const int error = allow_if(filter, SCMP_SYS(mmap), is_data);
  return error == 0 ? allow_if(filter, SCMP_SYS(mprotect), is_data) : error;
}

/* The rules beside the plain list: each of them looks at an argument. */
static int add_conditions(scmp_filter_ctx filter) {
  /* A thread, not a process. clone3 keeps its flags in memory, where a filter cannot look. */
  int error =
      allow_if(filter, SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD));
  if (error == 0) error = seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
  /* signals to its own threads, as abort() sends one */
  if (error == 0) {
    error = allow_if(filter, SCMP_SYS(tgkill), SCMP_A0_32(SCMP_CMP_EQ, (unsigned)getpid()));
  }
  /* fstat of the C library, which gives an empty path. A filter cannot see the path: whoever has
   * taken over a worker may learn that a file exists, not open it. */
  if (error == 0) {
    error = allow_if(filter, SCMP_SYS(newfstatat), SCMP_A0(SCMP_CMP_LE, most_descriptors));
  }
  /* reading limits, not setting them */
  if (error == 0) error = allow_if(filter, SCMP_SYS(prlimit64), SCMP_A2(SCMP_CMP_EQ, 0));
  if (error == 0) error = add_fcntl(filter);
  return error == 0 ? add_memory(filter) : error;
}

static bool filter_calls(fault *why) {
  if (SANITIZED) return true;
  scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
  if (filter == NULL) return fail(why, "seccomp", ENOMEM);
  int error = 0;
  for (int k = 0; k < CALLS && error == 0; k++) {
    error = seccomp_rule_add(filter, SCMP_ACT_ALLOW, allowed[k], 0);
  }
  if (error == 0) error = add_conditions(filter);
  if (error == 0) error = seccomp_load(filter);
  seccomp_release(filter);
  return error == 0 || fail(why, "seccomp", -error);
}

/* A memory file is not of the address space, and a body may be a file on a disk: neither may grow
 * above what the worker may have. Whoever tries gets EFBIG, not a signal. */
static void limit_files(void) {
  struct rlimit memory;
  if (getrlimit(RLIMIT_AS, &memory) == 0) limit(RLIMIT_FSIZE, memory.rlim_cur);
  signal(SIGXFSZ, SIG_IGN);
}

bool sandbox_enter(fault *why) {
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return fail(why, "no_new_privs", errno);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_NOFILE, most_descriptors);
  limit_files();
  if (!SANITIZED) forget_files();
  return filter_calls(why);
}
