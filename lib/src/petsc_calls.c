#include "petsc_calls.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "alloc.h"

#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED
#elif defined(__has_feature) /* clang's way to say it */
#if __has_feature(address_sanitizer)
#define SANITIZED
#endif
#endif
#ifdef SANITIZED
#include <sanitizer/lsan_interface.h>
#define KEEP_FOR_GOOD __lsan_disable()
#define KEEP_NO_MORE __lsan_enable()
#define IGNORE(block) __lsan_ignore_object(block)
#define CHECK_LEAKS_NOW __lsan_do_leak_check() /* instead of at the end */
const char *__lsan_default_suppressions(void);
__attribute__((weak)) const char *__lsan_default_suppressions(void) {
  return "leak:libpmix\n"; /* what launched processes ask of each other */
}
#else
#define KEEP_FOR_GOOD (void)0
#define KEEP_NO_MORE (void)0
#define IGNORE(block) (void)(block)
#define CHECK_LEAKS_NOW (void)0
#endif

static pthread_once_t once = PTHREAD_ONCE_INIT;
static petsc_calls calls;
static sct_error failure; /* of opening; code SCT_OK: there was none */
static _Thread_local char complaint[200];

const char *petsc_complaint(void) {
  return complaint[0] == '\0' ? "no message" : complaint;
}

/* Only the first of the messages of an error says what happened, the others where. */
static PetscErrorCode keep_message(MPI_Comm comm, int line, const char *function, const char *file,
                                   PetscErrorCode code, PetscErrorType type, const char *text,
                                   void *context) {
  (void)comm, (void)line, (void)file, (void)context;
  if (type == PETSC_ERROR_INITIAL) {
    snprintf(complaint, sizeof complaint, "%s: %s", function, text == NULL ? "" : text);
  }
  return code;
}

/* Memory of PETSc's own is that of the library, so that its failures can be tested. */

struct petsc_block {
  petsc_block *next, **link; /* link points here; NULL: on no list */
  int64_t bytes, unused;     /* of what follows */
};

/* PETSc keeps lists whose nodes it allocates among the objects: less than this may belong to one of
 * them, and stays when objects are abandoned. */
enum { ARRAY = 256 };
_Static_assert(sizeof(petsc_block) % 16 == 0, "what follows a block is aligned");

static _Thread_local petsc_block **owner;
static _Thread_local bool has_run_out;

void petsc_own(petsc_block **list) {
  owner = list;
  has_run_out = false;
}

bool petsc_ran_out(void) {
  return has_run_out;
}

static void list_block(petsc_block *block, petsc_block **list) {
  block->link = list;
  if (list == NULL) IGNORE(block); /* kept for good */
  if (list == NULL) return;
  block->next = *list;
  if (block->next != NULL) block->next->link = &block->next;
  *list = block;
}

static void unlist_block(petsc_block *block) {
  if (block->link == NULL) return;
  *block->link = block->next;
  if (block->next != NULL) block->next->link = block->link;
}

void petsc_abandon(petsc_block **list) {
  while (*list != NULL) {
    petsc_block *block = *list;
    unlist_block(block);
    block->link = NULL;
    if (block->bytes >= ARRAY) {
      sct_release(&block);
    } else {
      IGNORE(block);
    }
  }
}

void petsc_keep(petsc_block **list) {
  while (*list != NULL) {
    petsc_block *const block = *list;
    unlist_block(block);
    block->link = NULL;
    IGNORE(block);
  }
}

static PetscErrorCode ran_out(void **memory) {
  *memory = NULL;
  has_run_out = true;
  return PETSC_ERR_MEM;
}

static PetscErrorCode take(size_t size, PetscBool zeroed, int line, const char *function,
                           const char *file, void **memory) {
  petsc_block *block = NULL;
  const int64_t bytes = (int64_t)(size + sizeof *block);
  (void)line, (void)function, (void)file;
  *memory = NULL;
  if (size == 0) return 0;
  if ((zeroed ? sct_alloc_zero : sct_alloc)(&block, bytes, 1, NULL) != SCT_OK) {
    return ran_out(memory);
  }
  block->bytes = (int64_t)size;
  list_block(block, owner);
  *memory = block + 1;
  return 0;
}

static PetscErrorCode give_back(void *memory, int line, const char *function, const char *file) {
  (void)line, (void)function, (void)file;
  if (memory == NULL) return 0;
  petsc_block *block = (petsc_block *)memory - 1;
  unlist_block(block);
  sct_release(&block);
  return 0;
}

static PetscErrorCode resize(size_t size, int line, const char *function, const char *file,
                             void **memory) {
  if (*memory == NULL) return take(size, PETSC_FALSE, line, function, file, memory);
  petsc_block *block = (petsc_block *)*memory - 1;
  petsc_block **const list = block->link == NULL ? NULL : owner;
  if (size == 0) {
    *memory = NULL;
    return give_back(block + 1, line, function, file);
  }
  unlist_block(block);
  if (size < ARRAY) size = ARRAY; /* an array, however small */
  const sct_status status = sct_realloc(&block, (int64_t)(size + sizeof *block), 1, NULL);
  if (status == SCT_OK) block->bytes = (int64_t)size;
  list_block(block, list); /* grown or not, it may have been put at the head of the list */
  *memory = block + 1;
  has_run_out = has_run_out || status != SCT_OK;
  return status == SCT_OK ? 0 : PETSC_ERR_MEM;
}

/* Open MPI by itself: no daemon beside the process, no directory, no shared memory, no network.
 * Under a launcher, which has a say in this, nothing is set. */
static void stay_alone(void) {
  static const char *const settings[][2] = {
      {"OMPI_MCA_ess_singleton_isolated", "1"},
      {"OMPI_MCA_orte_create_session_dirs", "0"},
      {"OMPI_MCA_pmix", "isolated"},
      {"OMPI_MCA_pml", "ob1"},
      {"OMPI_MCA_btl", "self"},
      {"OMPI_MCA_shmem", "mmap"},
      {"OMPI_MCA_mpi_param_files", "none"},
      {"OMPI_MCA_mca_base_param_files", "none"},
      {"OMPI_MCA_osc", "pt2pt"},
      {"HWLOC_COMPONENTS", "linux,stop"},
      {"OMPI_MCA_opal_signal", ""},
  };
  if (getenv("OMPI_COMM_WORLD_SIZE") != NULL || getenv("PMIX_RANK") != NULL) return;
  for (size_t k = 0; k < sizeof settings / sizeof *settings; k++) {
    setenv(settings[k][0], settings[k][1], 0);
  }
}

static bool find_functions(void *library) {
#define PETSC_FIND(name)                       \
  {                                            \
    void *const found = dlsym(library, #name); \
    if (found == NULL) return false;           \
    memcpy(&calls.name, &found, sizeof found); \
  }
  PETSC_CALLS(PETSC_FIND)
#undef PETSC_FIND
#ifdef OPEN_MPI /* its constants are addresses there, numbers else */
  calls.self = dlsym(library, "ompi_mpi_comm_self");
  calls.world = dlsym(library, "ompi_mpi_comm_world");
  calls.number = dlsym(library, "ompi_mpi_double");
  calls.sum = dlsym(library, "ompi_mpi_op_sum");
  calls.most = dlsym(library, "ompi_mpi_op_max");
  return calls.self && calls.world && calls.number && calls.sum && calls.most;
#else
  calls.self = MPI_COMM_SELF;
  calls.world = MPI_COMM_WORLD;
  calls.number = MPI_DOUBLE;
  calls.sum = MPI_SUM;
  calls.most = MPI_MAX;
  return true;
#endif
}

/* hypre's multigrid for these matrices (tests/bench/bench_solve.md): PMIS coarsening, extended+i
 * interpolation of four entries a row, one forward Gauss-Seidel sweep before and after. */
static PetscErrorCode set_options(void) {
  static const char *const settings[][2] = {
      {"-skip_petscrc", "1"},    {"-no_signal_handler", "1"},          {"-nox", "1"},
      {"-options_left", "0"},
#define MULTIGRID(prefix, levels)                                             \
  {"-" prefix "pc_type", "hypre"}, {"-" prefix "pc_hypre_type", "boomeramg"}, \
      {"-" prefix "pc_hypre_boomeramg_coarsen_type", "PMIS"},                 \
      {"-" prefix "pc_hypre_boomeramg_interp_type", "ext+i"},                 \
      {"-" prefix "pc_hypre_boomeramg_P_max", "4"},                           \
      {"-" prefix "pc_hypre_boomeramg_strong_threshold", "0.25"},             \
      {"-" prefix "pc_hypre_boomeramg_relax_type_all", "SOR/Jacobi"},         \
      {"-" prefix "pc_hypre_boomeramg_agg_nl", levels}
      MULTIGRID(PETSC_AMG, "0"), MULTIGRID(PETSC_AMG_AGGRESSIVE, "1"),
#undef MULTIGRID
  };
  for (size_t k = 0; k < sizeof settings / sizeof *settings; k++) {
    const PetscErrorCode code = calls.PetscOptionsSetValue(NULL, settings[k][0], settings[k][1]);
    if (code != 0) return code;
  }
  return 0;
}

static PetscErrorCode start(void) {
  stay_alone();
  PetscErrorCode code = calls.PetscMallocSet(take, give_back, resize);
  if (code == 0) code = set_options();
  if (code == 0) code = calls.PetscInitializeNoArguments();
  if (code == 0) code = calls.PetscPushErrorHandler(keep_message, NULL);
  return code;
}

/* MPI does not survive a lack of address space while it starts, so that is looked for first; it was
 * found to take 270 MB, and whoever has less than twice that beside needs it for other things. */
static bool has_address_space(void) {
  const size_t needed = (size_t)768 << 20;
  void *const room =
      mmap(NULL, needed, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return room != MAP_FAILED && munmap(room, needed) == 0;
}

static void open_once(void) {
  if (!has_address_space()) {
    (void)sct_fail(&failure, SCT_E_MEMORY, -1, "no address space for PETSc: 768 MB are not free");
    return;
  }
  KEEP_FOR_GOOD;
  void *library = dlopen(SCATTER_PETSC_LIBRARY, RTLD_LAZY | RTLD_GLOBAL); /* MPI's plug-ins look */
  const char *reason = library == NULL ? dlerror() : "";                  /* for its symbols */
  if (library == NULL || !find_functions(library)) {
    (void)sct_fail(&failure,
                   strstr(reason, "memory") == NULL && strstr(reason, "map") == NULL
                       ? SCT_E_ARGUMENT
                       : SCT_E_MEMORY,
                   -1, "the iterative solver needs PETSc, %s: %.200s", SCATTER_PETSC_LIBRARY,
                   library == NULL ? reason : "another version");
  } else if (start() != 0) {
    (void)sct_fail(&failure, SCT_E_MEMORY, -1, "PETSc does not start: %s", petsc_complaint());
  }
  KEEP_NO_MORE;
}

const petsc_calls *petsc_open(sct_error *err) {
  pthread_once(&once, open_once);
  if (failure.code == SCT_OK) return &calls;
  if (err != NULL) *err = failure;
  return NULL;
}

/* MPI unloads its plug-ins without freeing all that was theirs. */
void petsc_close(void) {
  CHECK_LEAKS_NOW;
  (void)calls.PetscFinalize();
}
