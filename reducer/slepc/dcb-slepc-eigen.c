/* Lowest elastic eigenpairs of K x = λ M x with SLEPc, started by `reduce` under mpirun (docs/slepc.md).
 *
 *     M x = θ (K + σ M) x,   θ = 1/(λ + σ):   the largest θ are the lowest λ
 *
 * is shift-and-invert at -σ with the positive definite matrix as B: one Cholesky factorization by MUMPS, Krylov–Schur in its
 * inner product (which a mass matrix with massless dofs does not spoil), the rigid motions deflated. A Krylov space may
 * miss copies of a multiple root, so the search is repeated in the complement of all that is found until nothing turns up
 * there that lies above the last pair of the first search.
 *
 * Files in the folder, all PETSc binary: `stiffness`, `mass` (Mat), `rigid` (-dcb_rigid Vecs) are read; `eigenvalues`
 * (Vec of θ, descending, then Vec of one number, the restarts) and `shapes` (one Vec per θ) are written.
 */
#include <slepceps.h>

#if defined(PETSC_USE_COMPLEX) || defined(PETSC_USE_64BIT_INDICES) || !defined(PETSC_USE_REAL_DOUBLE)
#error "reduce exchanges files of doubles and 32-bit indices: install libslepc-real-dev, or name its pkg-config files in PKG_CONFIG_PATH"
#endif
#if !defined(PETSC_HAVE_MUMPS)
#error "this PETSc was built without MUMPS"
#endif

/* Wanted in a repeated search, and its Krylov space. */
#define AGAIN_WANTED 1
#define AGAIN_SPACE 24

typedef struct {
  char      folder[PETSC_MAX_PATH_LEN];
  PetscReal shift, tolerance;
  PetscInt  wanted, rigid, seed;
} Task;

/* Pairs found so far; the first `fixed` vectors are the rigid motions. */
typedef struct {
  Vec       *vectors;
  PetscReal *theta;
  PetscInt   fixed, count, capacity, restarts;
} Found;

static PetscErrorCode ReadTask(Task *task)
{
  PetscBool folder, shift, wanted;

  PetscFunctionBeginUser;
  task->tolerance = 1e-10;
  task->rigid     = 0;
  task->seed      = 0;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-dcb_folder", task->folder, sizeof(task->folder), &folder));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-dcb_shift", &task->shift, &shift));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-dcb_wanted", &task->wanted, &wanted));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-dcb_rigid", &task->rigid, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-dcb_seed", &task->seed, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-dcb_tolerance", &task->tolerance, NULL));
  PetscCheck(folder && shift && wanted, PETSC_COMM_WORLD, PETSC_ERR_USER_INPUT, "started without -dcb_folder, -dcb_shift, -dcb_wanted: this program is for `reduce`");
  PetscFunctionReturn(0);
}

static PetscErrorCode OpenFile(const Task *task, const char *name, PetscFileMode mode, PetscViewer *viewer)
{
  char path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", task->folder, name));
  PetscCall(PetscViewerCreate(PETSC_COMM_WORLD, viewer));
  PetscCall(PetscViewerSetType(*viewer, PETSCVIEWERBINARY));
  PetscCall(PetscViewerBinarySkipInfo(*viewer));
  PetscCall(PetscViewerFileSetMode(*viewer, mode));
  PetscCall(PetscViewerFileSetName(*viewer, path));
  PetscFunctionReturn(0);
}

static PetscErrorCode LoadMatrix(const Task *task, const char *name, Mat *matrix)
{
  PetscViewer viewer;

  PetscFunctionBeginUser;
  PetscCall(OpenFile(task, name, FILE_MODE_READ, &viewer));
  PetscCall(MatCreate(PETSC_COMM_WORLD, matrix));
  PetscCall(MatSetType(*matrix, MATAIJ));
  PetscCall(MatLoad(*matrix, viewer));
  PetscCall(MatSetOption(*matrix, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(PetscViewerDestroy(&viewer));
  PetscFunctionReturn(0);
}

static PetscErrorCode LoadRigid(const Task *task, Mat like, Found *found)
{
  PetscViewer viewer;

  PetscFunctionBeginUser;
  if (task->rigid == 0) PetscFunctionReturn(0);
  PetscCall(OpenFile(task, "rigid", FILE_MODE_READ, &viewer));
  for (PetscInt i = 0; i < task->rigid; i++) {
    PetscCall(MatCreateVecs(like, &found->vectors[i], NULL));
    PetscCall(VecLoad(found->vectors[i], viewer));
  }
  found->fixed = task->rigid;
  PetscCall(PetscViewerDestroy(&viewer));
  PetscFunctionReturn(0);
}

/* One line per restart, which `reduce` turns into progress. */
static PetscErrorCode Report(EPS eps, PetscInt restarts, PetscInt converged, PetscScalar *re, PetscScalar *im, PetscReal *errors, PetscInt pairs, void *context)
{
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "converged %" PetscInt_FMT "\n", converged));
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateSolver(const Task *task, Mat mass, Mat shifted, EPS *eps)
{
  ST          st;
  KSP         ksp;
  PC          pc;
  BV          bv;
  PetscRandom random;

  PetscFunctionBeginUser;
  PetscCall(EPSCreate(PETSC_COMM_WORLD, eps));
  PetscCall(EPSSetOperators(*eps, mass, shifted));
  PetscCall(EPSSetProblemType(*eps, EPS_GHEP));
  PetscCall(EPSSetType(*eps, EPSKRYLOVSCHUR));
  PetscCall(EPSSetWhichEigenpairs(*eps, EPS_LARGEST_REAL));
  PetscCall(EPSSetTolerances(*eps, task->tolerance, 1000));
  /* Purification is for a semidefinite B; this one is definite. */
  PetscCall(EPSSetPurify(*eps, PETSC_FALSE));
  PetscCall(EPSMonitorSet(*eps, Report, NULL, NULL));
  PetscCall(EPSGetST(*eps, &st));
  PetscCall(STGetKSP(st, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPSetErrorIfNotConverged(ksp, PETSC_TRUE));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCCHOLESKY));
  PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  PetscCall(EPSGetBV(*eps, &bv));
  PetscCall(BVGetRandomContext(bv, &random));
  PetscCall(PetscRandomSetSeed(random, 0x5eed + (unsigned long)task->seed));
  PetscCall(PetscRandomSeed(random));
  PetscCall(EPSSetFromOptions(*eps));
  PetscFunctionReturn(0);
}

/* Searches the complement of all that is known; keeps pairs with θ above `limit` and tells how many. */
static PetscErrorCode Search(EPS eps, Mat like, PetscInt wanted, PetscInt space, PetscReal limit, Found *found, PetscInt *kept)
{
  PetscInt n, known = found->fixed + found->count, converged, restarts;

  PetscFunctionBeginUser;
  *kept = 0;
  PetscCall(MatGetSize(like, &n, NULL));
  wanted = PetscMin(wanted, n - known);
  if (wanted <= 0) PetscFunctionReturn(0);
  space = PetscMin(PetscMax(space, wanted), n);
  PetscCall(EPSSetDimensions(eps, wanted, space, PETSC_DEFAULT));
  PetscCall(EPSSetDeflationSpace(eps, known, found->vectors));
  PetscCall(EPSSolve(eps));
  PetscCall(EPSGetConverged(eps, &converged));
  PetscCall(EPSGetIterationNumber(eps, &restarts));
  found->restarts += restarts;
  for (PetscInt i = 0; i < converged && found->count < found->capacity; i++) {
    PetscScalar theta;
    Vec        *next = &found->vectors[found->fixed + found->count];

    PetscCall(EPSGetEigenvalue(eps, i, &theta, NULL));
    if (theta <= limit) continue;
    PetscCall(MatCreateVecs(like, next, NULL));
    PetscCall(EPSGetEigenvector(eps, i, *next, NULL));
    found->theta[found->count++] = theta;
    (*kept)++;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode SearchUntilComplete(EPS eps, Mat like, const Task *task, Found *found)
{
  PetscInt  kept;
  PetscReal last = PETSC_MAX_REAL;

  PetscFunctionBeginUser;
  PetscCall(Search(eps, like, task->wanted, PetscMax(2 * task->wanted, task->wanted + AGAIN_SPACE), 0.0, found, &kept));
  for (PetscInt i = 0; i < found->count; i++) last = PetscMin(last, found->theta[i]);
  while (kept > 0) PetscCall(Search(eps, like, AGAIN_WANTED, AGAIN_SPACE, last, found, &kept));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteNumbers(PetscViewer viewer, PetscInt count, const PetscReal *numbers, const PetscInt *order)
{
  Vec      vector;
  PetscInt first, end;

  PetscFunctionBeginUser;
  PetscCall(VecCreateMPI(PETSC_COMM_WORLD, PETSC_DECIDE, count, &vector));
  PetscCall(VecGetOwnershipRange(vector, &first, &end));
  for (PetscInt i = first; i < end; i++) PetscCall(VecSetValue(vector, i, numbers[order ? order[i] : i], INSERT_VALUES));
  PetscCall(VecAssemblyBegin(vector));
  PetscCall(VecAssemblyEnd(vector));
  PetscCall(VecView(vector, viewer));
  PetscCall(VecDestroy(&vector));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteFound(const Task *task, const Found *found)
{
  PetscViewer viewer;
  PetscInt   *order;
  PetscReal  *negative, restarts = (PetscReal)found->restarts;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(found->count, &order, found->count, &negative));
  for (PetscInt i = 0; i < found->count; i++) {
    order[i]    = i;
    negative[i] = -found->theta[i];
  }
  PetscCall(PetscSortRealWithPermutation(found->count, negative, order));
  PetscCall(OpenFile(task, "shapes", FILE_MODE_WRITE, &viewer));
  for (PetscInt i = 0; i < found->count; i++) PetscCall(VecView(found->vectors[found->fixed + order[i]], viewer));
  PetscCall(PetscViewerDestroy(&viewer));
  PetscCall(OpenFile(task, "eigenvalues", FILE_MODE_WRITE, &viewer));
  PetscCall(WriteNumbers(viewer, found->count, found->theta, order));
  PetscCall(WriteNumbers(viewer, 1, &restarts, NULL));
  PetscCall(PetscViewerDestroy(&viewer));
  PetscCall(PetscFree2(order, negative));
  PetscFunctionReturn(0);
}

static PetscErrorCode Run(void)
{
  Task     task;
  Mat      mass, shifted;
  EPS      eps;
  Found    found = {0};
  PetscInt n;

  PetscFunctionBeginUser;
  PetscCall(ReadTask(&task));
  PetscCall(LoadMatrix(&task, "stiffness", &shifted));
  PetscCall(LoadMatrix(&task, "mass", &mass));
  PetscCall(MatAXPY(shifted, task.shift, mass, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatSetOption(shifted, MAT_SPD, PETSC_TRUE));
  PetscCall(MatGetSize(mass, &n, NULL));
  /* A search may converge more than it was asked for, and copies of roots come on top. */
  found.capacity = PetscMin(4 * task.wanted + AGAIN_SPACE, n);
  PetscCall(PetscCalloc2(task.rigid + found.capacity, &found.vectors, found.capacity, &found.theta));
  PetscCall(LoadRigid(&task, mass, &found));
  PetscCall(CreateSolver(&task, mass, shifted, &eps));
  PetscCall(SearchUntilComplete(eps, mass, &task, &found));
  PetscCall(WriteFound(&task, &found));
  for (PetscInt i = 0; i < found.fixed + found.count; i++) PetscCall(VecDestroy(&found.vectors[i]));
  PetscCall(PetscFree2(found.vectors, found.theta));
  PetscCall(EPSDestroy(&eps));
  PetscCall(MatDestroy(&shifted));
  PetscCall(MatDestroy(&mass));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  PetscCall(SlepcInitialize(&argc, &argv, NULL, NULL));
  PetscCall(Run());
  PetscCall(SlepcFinalize());
  return 0;
}
