/* In the place of solve_petsc.c where PETSc was not there when the library was built. */
#include "solve_kind.h"

static sct_status load(sct_error *err) {
  return sct_fail(err, SCT_E_ARGUMENT, -1,
                  "the iterative solver needs PETSc, which this library was built without "
                  "(Debian: petsc-dev)");
}

const sct_solve_kind sct_solve_petsc = {.name = "iterative", .iterates = true, .load = load};
