/* CHOLMOD (SuiteSparse) for ctypes: analysis, factorization and solves apart, and the size and flops of the factor.
   Build: gcc -O2 -shared -fPIC cholmod_shim.c -o libcholmod_shim.so -lcholmod     (Debian: libsuitesparse-dev) */
#include <stdlib.h>
#include <string.h>
#include <suitesparse/cholmod.h>

typedef struct {
    cholmod_common common;
    cholmod_sparse matrix;
    cholmod_factor *factor;
    cholmod_dense *solution, *y, *e; /* kept from solve to solve */
} solver;

/* ordering: 2 AMD, 3 METIS, 4 NESDIS */
void *shim_new(int ordering) {
    solver *s = calloc(1, sizeof(solver));
    cholmod_l_start(&s->common);
    s->common.nmethods = 1;
    s->common.method[0].ordering = ordering;
    s->common.postorder = 1;
    s->common.supernodal = CHOLMOD_SUPERNODAL;
    s->common.print = 0;
    return s;
}

/* The lower triangle by compressed columns. */
int shim_analyze(solver *s, long n, long *p, long *i, double *x) {
    s->matrix = (cholmod_sparse){.nrow = n, .ncol = n, .nzmax = p[n], .p = p, .i = i, .x = x, .stype = -1,
                                 .itype = CHOLMOD_LONG, .xtype = CHOLMOD_REAL, .dtype = CHOLMOD_DOUBLE,
                                 .sorted = 1, .packed = 1};
    s->factor = cholmod_l_analyze(&s->matrix, &s->common);
    return s->common.status;
}

int shim_factor(solver *s) {
    cholmod_l_factorize(&s->matrix, s->factor, &s->common);
    return s->common.status ? s->common.status : (s->factor->minor < s->factor->n);
}

int shim_solve(solver *s, long n, long columns, double *b, double *x) {
    cholmod_dense right = {.nrow = n, .ncol = columns, .nzmax = n * columns, .d = n, .x = b,
                           .xtype = CHOLMOD_REAL, .dtype = CHOLMOD_DOUBLE};
    int done = cholmod_l_solve2(CHOLMOD_A, s->factor, &right, NULL, &s->solution, NULL, &s->y, &s->e, &s->common);
    if (done) memcpy(x, s->solution->x, sizeof(double) * n * columns);
    return !done;
}

/* Entries of the factor, flops, entries stored, supernodes. */
void shim_stats(solver *s, double *out) {
    out[0] = s->common.lnz;
    out[1] = s->common.fl;
    out[2] = (double)s->factor->xsize;
    out[3] = (double)s->factor->nsuper;
}
