/* A sparse symmetric factor spread over MPI processes by MUMPS, for `reduce --ranks` (docs/ranks.md).
 *
 *     mpirun -n N dcb-mumps-factor FOLDER
 *
 * `reduce` writes one command a line to the standard input of rank 0 and reads one reply a line, beginning with "dcb ":
 *
 *     factorize    read `matrix`, A = L L^T                    dcb factorized ENTRIES | dcb indefinite
 *     count        read `matrix`, signs of the pivots of A     dcb counted NEGATIVE ZERO
 *     solve K      read K columns from `block`, write A^-1 b   dcb solved
 *     release      give up the factor                          dcb released
 *     memory       peak resident bytes of each rank            dcb memory BYTES ...
 *     end          all ranks end                               (nothing)
 *
 * The end of the input without `end` means that `reduce` is gone: all ranks end at once and their files are removed.
 * A failure is one line "dcb failed ..." and the end of all ranks.
 *
 * `matrix`: n and the number of entries (64 bits), rows, then columns of the lower triangle (32 bits, from 1), values
 * (doubles), place of each row in the order of elimination (32 bits, from 1); removed once it is read. `block`: columns of n
 * doubles. Only the machine of rank 0 sees the folder; each rank is sent its share of the entries.
 */
#include <dmumps_c.h>
#include <mpi.h>

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

/* Rows and columns are 32 bits in `matrix`; MUMPS counts entries, and everything that grows faster than dofs, with 64 bits in either case. */
_Static_assert(sizeof(MUMPS_INT) == 4, "this MUMPS was built with -DINTSIZE64; take one built without it, which counts entries of a factor with 64 bits, too");

/* Entries sent at a time. */
#define PIECE (1 << 20)
/* Between two looks whether there is a command: waiting ranks leave their cores to others. */
#define SHORTEST_PAUSE_NS 20000L
#define LONGEST_PAUSE_NS 1000000L
/* More room for pivoting than was foreseen, in percent, and how often it is doubled. */
#define FIRST_MORE_ROOM 30
#define LAST_MORE_ROOM 1000

enum { POSITIVE = 1, INDEFINITE = 2 };
enum { FACTORIZE, COUNT, SOLVE, RELEASE, MEMORY, END, UNKNOWN };

typedef struct {
  int32_t kind, columns;
} Command;

typedef struct {
  const char     *folder;
  int             rank, ranks;
  int64_t         rows;
  int             has_factor;
  DMUMPS_STRUC_C  factor;
} Program;

/* Entries of one rank, and on rank 0 the order. */
typedef struct {
  int64_t    rows, count;
  MUMPS_INT *row, *column, *order;
  double    *value;
} Share;

/* ---- The end ---------------------------------------------------------------------------------------------------- */

/* One message, then the end of all ranks. */
static void fail(const char *format, ...)
{
  va_list arguments;

  va_start(arguments, format);
  fputs("dcb failed ", stdout);
  vprintf(format, arguments);
  fputs("\n", stdout);
  va_end(arguments);
  fflush(stdout);
  MPI_Abort(MPI_COMM_WORLD, 1);
  _exit(1);
}

static void path_of(const char *folder, const char *name, char path[PATH_MAX])
{
  if (snprintf(path, PATH_MAX, "%s/%s", folder, name) >= PATH_MAX) fail("the path of %s is too long", name);
}

static void *room(size_t bytes, const char *what)
{
  void *memory = malloc(bytes > 0 ? bytes : 1);

  if (!memory) fail("out of memory for %s (%zu bytes)", what, bytes);
  return memory;
}

/* ---- Commands --------------------------------------------------------------------------------------------------- */

static struct {
  pthread_mutex_t lock;
  pthread_cond_t  changed;
  int             is_full;
  Command         command;
  const char     *folder;
} inbox = {.lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

static Command parsed(const char *line)
{
  static const struct {
    const char *name;
    int32_t     kind;
  } names[] = {{"factorize\n", FACTORIZE}, {"count\n", COUNT}, {"release\n", RELEASE}, {"memory\n", MEMORY}, {"end\n", END}};
  Command command = {UNKNOWN, 0};

  for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++)
    if (!strcmp(line, names[i].name)) command.kind = names[i].kind;
  if (sscanf(line, "solve %" SCNd32 "\n", &command.columns) == 1 && command.columns > 0) command.kind = SOLVE;
  return command;
}

/* Reads ahead of the work, so that the end of the input is noticed during it too. */
static void *read_commands(void *nothing)
{
  char line[64], path[PATH_MAX];

  (void)nothing;
  while (fgets(line, sizeof(line), stdin)) {
    Command command = parsed(line);

    pthread_mutex_lock(&inbox.lock);
    while (inbox.is_full) pthread_cond_wait(&inbox.changed, &inbox.lock);
    inbox.command = command;
    inbox.is_full = 1;
    pthread_cond_broadcast(&inbox.changed);
    pthread_mutex_unlock(&inbox.lock);
    if (command.kind == END) return NULL;
  }
  path_of(inbox.folder, "matrix", path);
  unlink(path);
  path_of(inbox.folder, "block", path);
  unlink(path);
  rmdir(inbox.folder);
  /* mpirun ends the others. */
  _exit(1);
}

static Command next_command(const Program *program)
{
  Command     command = {UNKNOWN, 0};
  MPI_Request request;
  int         is_here = 0;
  long        pause = SHORTEST_PAUSE_NS;

  if (program->rank == 0) {
    pthread_mutex_lock(&inbox.lock);
    while (!inbox.is_full) pthread_cond_wait(&inbox.changed, &inbox.lock);
    command = inbox.command;
    inbox.is_full = 0;
    pthread_cond_broadcast(&inbox.changed);
    pthread_mutex_unlock(&inbox.lock);
  }
  MPI_Ibcast(&command, 2, MPI_INT32_T, 0, MPI_COMM_WORLD, &request);
  for (MPI_Test(&request, &is_here, MPI_STATUS_IGNORE); !is_here; MPI_Test(&request, &is_here, MPI_STATUS_IGNORE)) {
    struct timespec time = {0, pause};

    nanosleep(&time, NULL);
    if (pause < LONGEST_PAUSE_NS) pause += pause / 4;
  }
  return command;
}

/* ---- Files ------------------------------------------------------------------------------------------------------ */

static int opened(const Program *program, const char *name, int flags)
{
  char path[PATH_MAX];
  int  file;

  path_of(program->folder, name, path);
  file = open(path, flags);
  if (file < 0) fail("cannot open %s: %s (the machine of rank 0 must see this folder)", path, strerror(errno));
  return file;
}

static void read_at(int file, void *to, int64_t bytes, int64_t at, const char *name)
{
  char *place = to;

  while (bytes > 0) {
    ssize_t got = pread(file, place, bytes > (1 << 30) ? (1 << 30) : (size_t)bytes, at);

    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail("`%s` ends early or cannot be read: %s", name, got < 0 ? strerror(errno) : "too short");
    place += got;
    at += got;
    bytes -= got;
  }
}

static void write_at(int file, const void *from, int64_t bytes, int64_t at, const char *name)
{
  const char *place = from;

  while (bytes > 0) {
    ssize_t put = pwrite(file, place, bytes > (1 << 30) ? (1 << 30) : (size_t)bytes, at);

    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) fail("`%s` cannot be written: %s", name, strerror(errno));
    place += put;
    at += put;
    bytes -= put;
  }
}

/* Sends every rank its slice of an array in the file, or reads rank 0's own. */
static void distribute(const Program *program, int file, int64_t at, int64_t count, int width, void *own)
{
  MPI_Datatype type = width == 4 ? MPI_INT32_T : MPI_DOUBLE;

  if (program->rank > 0) {
    int64_t mine = count * (program->rank + 1) / program->ranks - count * program->rank / program->ranks;

    for (int64_t done = 0; done < mine; done += PIECE) {
      int some = mine - done < PIECE ? (int)(mine - done) : PIECE;

      MPI_Recv((char *)own + done * width, some, type, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    return;
  }
  read_at(file, own, count / program->ranks * width, at, "matrix");
  if (program->ranks > 1) {
    void *piece = room((size_t)PIECE * (size_t)width, "a piece of the matrix");

    for (int rank = 1; rank < program->ranks; rank++) {
      int64_t end = count * (rank + 1) / program->ranks;

      for (int64_t first = count * rank / program->ranks; first < end; first += PIECE) {
        int some = end - first < PIECE ? (int)(end - first) : PIECE;

        read_at(file, piece, (int64_t)some * width, at + first * width, "matrix");
        MPI_Send(piece, some, type, rank, 0, MPI_COMM_WORLD);
      }
    }
    free(piece);
  }
}

static Share read_share(Program *program)
{
  Share   share = {0};
  int64_t sizes[2] = {0, 0}, at = sizeof(sizes);
  int     file = -1;
  char    path[PATH_MAX];

  if (program->rank == 0) {
    file = opened(program, "matrix", O_RDONLY);
    read_at(file, sizes, sizeof(sizes), 0, "matrix");
    if (sizes[0] < 1 || sizes[0] > INT32_MAX || sizes[1] < 0) fail("`matrix` is damaged");
  }
  MPI_Bcast(sizes, 2, MPI_INT64_T, 0, MPI_COMM_WORLD);
  share.rows   = sizes[0];
  share.count  = sizes[1] * (program->rank + 1) / program->ranks - sizes[1] * program->rank / program->ranks;
  share.row    = room((size_t)share.count * sizeof(*share.row), "the matrix");
  share.column = room((size_t)share.count * sizeof(*share.column), "the matrix");
  share.value  = room((size_t)share.count * sizeof(*share.value), "the matrix");
  distribute(program, file, at, sizes[1], 4, share.row);
  distribute(program, file, at += 4 * sizes[1], sizes[1], 4, share.column);
  distribute(program, file, at += 4 * sizes[1], sizes[1], 8, share.value);
  if (program->rank == 0) {
    share.order = room((size_t)share.rows * sizeof(*share.order), "the order");
    read_at(file, share.order, 4 * share.rows, at + 8 * sizes[1], "matrix");
    close(file);
    /* A folder in memory has no room to lose while the factor is made. */
    path_of(program->folder, "matrix", path);
    unlink(path);
  }
  return share;
}

static void give_up(Share *share)
{
  free(share->row);
  free(share->column);
  free(share->value);
  free(share->order);
}

/* ---- MUMPS ------------------------------------------------------------------------------------------------------ */

#define ICNTL(of, i) ((of)->icntl[(i)-1])
#define INFOG(of, i) ((of)->infog[(i)-1])

static void run_mumps(DMUMPS_STRUC_C *mumps, int job)
{
  mumps->job = job;
  dmumps_c(mumps);
}

static const char *meaning(int code)
{
  switch (code) {
  case -5:
  case -7:
  case -13:
  case -19: return "out of memory; use more ranks or larger machines";
  case -8:
  case -9:
  case -14:
  case -15:
  case -17:
  case -20: return "the room foreseen was too small";
  case -51:
  case -52: return "too large for this MUMPS with 32-bit integers";
  default: return "see INFOG(1) in the guide of MUMPS";
  }
}

static void refuse(const Program *program, const DMUMPS_STRUC_C *mumps, const char *phase)
{
  if (program->rank == 0) fail("MUMPS: %s ended with %d, %d: %s", phase, INFOG(mumps, 1), INFOG(mumps, 2), meaning(INFOG(mumps, 1)));
  MPI_Barrier(MPI_COMM_WORLD);
}

static int lacks_room(int code)
{
  return code == -8 || code == -9 || code == -14 || code == -15 || code == -17 || code == -20;
}

/* Analyses and factorizes; other results than success and a pivot that isn't wanted end the program. */
static void factorize(Program *program, DMUMPS_STRUC_C *mumps, int symmetry, const Share *share)
{
  memset(mumps, 0, sizeof(*mumps));
  mumps->sym          = symmetry;
  mumps->par          = 1;
  mumps->comm_fortran = (MUMPS_INT)MPI_Comm_c2f(MPI_COMM_WORLD);
  run_mumps(mumps, -1);
  if (INFOG(mumps, 1) < 0) refuse(program, mumps, "its start");
  for (int stream = 1; stream <= 3; stream++) ICNTL(mumps, stream) = -1;
  ICNTL(mumps, 4)  = 0;
  ICNTL(mumps, 7)  = 1; /* the order of elimination is given, */
  ICNTL(mumps, 28) = 1; /* and analysed by rank 0 */
  ICNTL(mumps, 18) = 3; /* entries are distributed */
  ICNTL(mumps, 14) = FIRST_MORE_ROOM;
  if (symmetry == POSITIVE) ICNTL(mumps, 8) = 0; /* scaling changes nothing in a Cholesky factorization */
  if (symmetry == INDEFINITE) {
    ICNTL(mumps, 12) = 1; /* the order stays as it is */
    ICNTL(mumps, 13) = 1; /* ScaLAPACK doesn't count signs */
    ICNTL(mumps, 31) = 1; /* nothing is kept */
  }
  mumps->n       = (MUMPS_INT)share->rows;
  mumps->nnz_loc = share->count;
  mumps->irn_loc = share->row;
  mumps->jcn_loc = share->column;
  mumps->a_loc   = share->value;
  mumps->perm_in = share->order;
  run_mumps(mumps, 1);
  if (INFOG(mumps, 1) < 0) refuse(program, mumps, "the analysis");
  run_mumps(mumps, 2);
  while (lacks_room(INFOG(mumps, 1)) && ICNTL(mumps, 14) < LAST_MORE_ROOM) {
    ICNTL(mumps, 14) *= 2;
    run_mumps(mumps, 2);
  }
}

static int has_zero_pivot(const DMUMPS_STRUC_C *mumps)
{
  return INFOG(mumps, 1) == -10 || INFOG(mumps, 1) == -40;
}

static void release(Program *program)
{
  if (program->has_factor) run_mumps(&program->factor, -2);
  program->has_factor = 0;
}

static void command_factorize(Program *program)
{
  DMUMPS_STRUC_C *mumps = &program->factor;
  Share           share;

  release(program);
  share = read_share(program);
  factorize(program, mumps, POSITIVE, &share);
  give_up(&share);
  mumps->irn_loc = mumps->jcn_loc = mumps->perm_in = NULL;
  mumps->a_loc                                     = NULL;
  program->rows                                    = share.rows;
  program->has_factor                              = 1;
  if (has_zero_pivot(mumps) || (INFOG(mumps, 1) >= 0 && INFOG(mumps, 12) > 0)) {
    release(program);
    if (program->rank == 0) puts("dcb indefinite");
    return;
  }
  if (INFOG(mumps, 1) < 0) refuse(program, mumps, "the factorization");
  if (program->rank == 0) {
    /* Millions where negative. */
    long long entries = INFOG(mumps, 29) < 0 ? -1000000LL * INFOG(mumps, 29) : INFOG(mumps, 29);

    printf("dcb factorized %lld\n", entries);
  }
}

static void command_count(Program *program)
{
  DMUMPS_STRUC_C mumps;
  Share          share = read_share(program);
  int            zero, negative;

  factorize(program, &mumps, INDEFINITE, &share);
  give_up(&share);
  mumps.irn_loc = mumps.jcn_loc = mumps.perm_in = NULL;
  mumps.a_loc                                   = NULL;
  zero                                          = has_zero_pivot(&mumps);
  if (!zero && INFOG(&mumps, 1) < 0) refuse(program, &mumps, "the count");
  negative = zero ? 0 : INFOG(&mumps, 12);
  run_mumps(&mumps, -2);
  if (program->rank == 0) printf("dcb counted %d %d\n", negative, zero);
}

static void command_solve(Program *program, int columns)
{
  DMUMPS_STRUC_C *mumps = &program->factor;
  int64_t         bytes = program->rows * columns * (int64_t)sizeof(double);
  int             file = -1;

  if (!program->has_factor || program->rows * columns > INT32_MAX) {
    if (program->rank == 0) fail("no factor, or a block of %d columns is too large", columns);
    MPI_Barrier(MPI_COMM_WORLD);
  }
  if (program->rank == 0) {
    file       = opened(program, "block", O_RDWR);
    mumps->rhs = room((size_t)bytes, "right-hand sides");
    read_at(file, mumps->rhs, bytes, 0, "block");
  }
  mumps->nrhs      = columns;
  mumps->lrhs      = (MUMPS_INT)program->rows;
  ICNTL(mumps, 27) = columns;
  run_mumps(mumps, 3);
  if (INFOG(mumps, 1) < 0) refuse(program, mumps, "the solution");
  if (program->rank == 0) {
    write_at(file, mumps->rhs, bytes, 0, "block");
    close(file);
    free(mumps->rhs);
    mumps->rhs = NULL;
    puts("dcb solved");
  }
}

static int64_t peak_resident(void)
{
  FILE         *status = fopen("/proc/self/status", "r");
  struct rusage usage;
  char          line[256];
  int64_t       kilobytes = 0;

  while (status && fgets(line, sizeof(line), status))
    if (sscanf(line, "VmHWM: %" SCNd64, &kilobytes) == 1) break;
  if (status) fclose(status);
  if (kilobytes > 0) return 1024 * kilobytes;
  getrusage(RUSAGE_SELF, &usage);
  return 1024 * (int64_t)usage.ru_maxrss;
}

static void command_memory(const Program *program)
{
  int64_t  mine = peak_resident();
  int64_t *all = program->rank == 0 ? room((size_t)program->ranks * sizeof(*all), "a list of ranks") : NULL;

  MPI_Gather(&mine, 1, MPI_INT64_T, all, 1, MPI_INT64_T, 0, MPI_COMM_WORLD);
  if (program->rank > 0) return;
  fputs("dcb memory", stdout);
  for (int rank = 0; rank < program->ranks; rank++) printf(" %" PRId64, all[rank]);
  puts("");
  free(all);
}

/* ---- The program ------------------------------------------------------------------------------------------------ */

/* One thread of BLAS for each rank unless something else is asked for; libraries read this when they are loaded. */
static void keep_to_one_thread(char **arguments)
{
  if (getenv("OMP_NUM_THREADS")) return;
  setenv("OMP_NUM_THREADS", "1", 1);
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  setenv("MKL_NUM_THREADS", "1", 0);
  execv("/proc/self/exe", arguments);
}

int main(int count, char **arguments)
{
  Program   program = {0};
  pthread_t reader;
  int       level;

  if (count != 2) {
    fputs("dcb-mumps-factor is started by `reduce --ranks`\n", stderr);
    return 2;
  }
  keep_to_one_thread(arguments);
  MPI_Init_thread(&count, &arguments, MPI_THREAD_FUNNELED, &level);
  MPI_Comm_rank(MPI_COMM_WORLD, &program.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &program.ranks);
  program.folder = inbox.folder = arguments[1];
  if (program.rank == 0) {
    if (pthread_create(&reader, NULL, read_commands, NULL)) fail("no thread can be started");
    printf("dcb ready %d\n", program.ranks);
    fflush(stdout);
  }
  for (Command command = next_command(&program); command.kind != END; command = next_command(&program)) {
    switch (command.kind) {
    case FACTORIZE: command_factorize(&program); break;
    case COUNT: command_count(&program); break;
    case SOLVE: command_solve(&program, command.columns); break;
    case MEMORY: command_memory(&program); break;
    case RELEASE:
      release(&program);
      if (program.rank == 0) puts("dcb released");
      break;
    default:
      if (program.rank == 0) fail("unknown command");
      MPI_Barrier(MPI_COMM_WORLD);
    }
    fflush(stdout);
  }
  release(&program);
  MPI_Finalize();
  return 0;
}
