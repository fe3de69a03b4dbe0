/* A solver that the conformance kit can judge: one JSON request a line in, one JSON answer a line out.

   Replace `solve` by your own. Everything else reads requests, refuses malformed ones, and writes answers.

       cc -O2 -o solver solver.c -lm                  computes in double
       cc -O2 -DREAL=float -o solver32 solver.c -lm   computes in float
*/
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef REAL
#define REAL double
#endif

typedef struct {
    int n, d, m;       /* robots, features, modalities */
    int *sizes;        /* columns of each modality, in order */
    REAL *X, *o;       /* X row by row, n x d; o, d */
    REAL lambda[3];
} Problem;

/* ---------------------------------------------------------------- the solver: put yours here

   minimise ||X'w - o||^2 + lambda1 ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||

   by accelerated proximal gradient steps with restarts. w (n) and u (d) come as zeros. */

static REAL dot(int k, const REAL *x, const REAL *y) {
    REAL sum = 0;
    for (int i = 0; i < k; i++) sum += x[i] * y[i];
    return sum;
}

static void solve(const Problem *P, REAL *w, REAL *u) {
    const int n = P->n, d = P->d, limit = 200000;
    const REAL l1 = P->lambda[0], l2 = P->lambda[1], l3 = P->lambda[2];
    const REAL still = sizeof(REAL) == 4 ? (REAL)1e-8 : (REAL)1e-16;
    REAL *room = calloc((size_t)(4 * n + 4 * d), sizeof(REAL));
    REAL *yw = room, *yu = yw + n, *p = yu + d, *q = p + d, *old_w = q + n, *old_u = old_w + n, *g_u = old_u + d;
    const REAL size = dot(n * d, P->X, P->X);
    const REAL bound_w = 2 * (size + 2 * l1), bound_u = 4 * l1 * size;
    REAL t = 1;
    for (int k = 0; k < limit; k++) {
        for (int j = 0; j < d; j++) p[j] = -P->o[j];
        for (int i = 0; i < n; i++) {
            q[i] = dot(d, P->X + (size_t)i * d, yu) - yw[i];
            for (int j = 0; j < d; j++) p[j] += P->X[(size_t)i * d + j] * yw[i];
        }
        memcpy(old_w, w, (size_t)n * sizeof(REAL));
        memcpy(old_u, u, (size_t)d * sizeof(REAL));
        for (int i = 0; i < n && bound_w > 0; i++) {
            REAL step = yw[i] - 2 * (dot(d, P->X + (size_t)i * d, p) - l1 * q[i]) / bound_w;
            REAL left = (REAL)fabs((double)step) - l2 / bound_w;
            w[i] = left > 0 ? (step > 0 ? left : -left) : 0;
        }
        memset(g_u, 0, (size_t)d * sizeof(REAL));
        for (int i = 0; i < n; i++)
            for (int j = 0; j < d; j++) g_u[j] += 2 * l1 * P->X[(size_t)i * d + j] * q[i];
        for (int i = 0, from = 0; i < P->m && bound_u > 0; from += P->sizes[i++]) {
            for (int j = from; j < from + P->sizes[i]; j++) u[j] = yu[j] - g_u[j] / bound_u;
            REAL norm = (REAL)sqrt((double)dot(P->sizes[i], u + from, u + from));
            REAL share = norm > l3 / bound_u ? 1 - l3 / bound_u / norm : 0;
            for (int j = from; j < from + P->sizes[i]; j++) u[j] *= share;
        }
        REAL turn = 0, moved = 0, length = 0, next = (1 + (REAL)sqrt(1 + 4 * (double)t * (double)t)) / 2;
        for (int i = 0; i < n; i++) {
            turn += bound_w * (yw[i] - w[i]) * (w[i] - old_w[i]);
            moved += bound_w * (w[i] - old_w[i]) * (w[i] - old_w[i]);
            length += bound_w * w[i] * w[i];
        }
        for (int j = 0; j < d; j++) {
            turn += bound_u * (yu[j] - u[j]) * (u[j] - old_u[j]);
            moved += bound_u * (u[j] - old_u[j]) * (u[j] - old_u[j]);
            length += bound_u * u[j] * u[j];
        }
        if (turn > 0) next = t = 1; /* the step turned back: restart */
        for (int i = 0; i < n; i++) yw[i] = w[i] + (t - 1) / next * (w[i] - old_w[i]);
        for (int j = 0; j < d; j++) yu[j] = u[j] + (t - 1) / next * (u[j] - old_u[j]);
        t = next;
        if (k > 0 && moved <= still * still * length) break;
    }
    free(room);
}

/* ---------------------------------------------------------------- reading: JSON, strictly */

static const char *at, *why;
static char *id;

static int fail(const char *reason) {
    if (!why) why = reason;
    return 0;
}

static void blank(void) {
    while (*at == ' ' || *at == '\t' || *at == '\r') at++;
}

static int take(char c) {
    blank();
    if (*at != c) return 0;
    at++;
    return 1;
}

static int text(const char **from, size_t *length) { /* a string, with its quotes and escapes */
    blank();
    if (*at != '"') return fail("a string was expected");
    *from = at++;
    while (*at && *at != '"') at += at[0] == '\\' && at[1] ? 2 : 1;
    if (*at != '"') return fail("a string has no end");
    *length = (size_t)(++at - *from);
    return 1;
}

static int number(double *value) {
    char *end;
    blank();
    if (!(*at >= '0' && *at <= '9') && !(*at == '-' && at[1] >= '0' && at[1] <= '9'))
        return fail("a number was expected");
    *value = strtod(at, &end);
    at = end;
    return isfinite(*value) && isfinite((REAL)*value) ? 1 : fail("a number is not finite");
}

static int numbers(REAL **values, int *count) { /* a list of numbers, appended */
    double value;
    if (!take('[')) return fail("a list was expected");
    if (take(']')) return 1;
    do {
        if (!number(&value)) return 0;
        *values = realloc(*values, (size_t)(*count + 1) * sizeof(REAL));
        (*values)[(*count)++] = (REAL)value;
    } while (take(','));
    return take(']') ? 1 : fail("a list has no end");
}

static int rows(Problem *P, int *n, int *width) {
    int count = 0;
    if (!take('[')) return fail("X must be a list of rows");
    if (take(']')) return fail("X has no rows");
    do {
        int before = count;
        if (!numbers(&P->X, &count)) return 0;
        if (*n && count - before != *width) return fail("rows of X have different lengths");
        *width = count - before;
        ++*n;
    } while (take(','));
    return take(']') ? 1 : fail("X has no end");
}

static int request(Problem *P) {
    static const char *keys[] = {"\"id\"", "\"n\"", "\"d\"", "\"modalities\"", "\"X\"", "\"o\"", "\"lambda1\"", "\"lambda2\"", "\"lambda3\""};
    int seen[9] = {0}, n = 0, width = 0, targets = 0, parts = 0, total = 0;
    double value, told[2] = {0, 0};
    REAL *sizes = NULL;
    if (!take('{')) return fail("an object was expected");
    do {
        const char *key, *name;
        size_t length, size;
        int k = 0, fine = 1;
        if (!text(&key, &length)) return 0;
        while (k < 9 && (strlen(keys[k]) != length || strncmp(keys[k], key, length))) k++;
        if (k == 9) return fail("a key is unknown");
        if (seen[k]++) return fail("a key is given twice");
        if (!take(':')) return fail("a colon was expected");
        if (k == 0) {
            fine = text(&name, &size);
            if (fine) memcpy(id = calloc(size + 1, 1), name, size);
        } else if (k <= 2 || k >= 6) {
            fine = number(&value);
            if (k <= 2) told[k - 1] = value; else P->lambda[k - 6] = (REAL)value;
        } else if (k == 3) fine = numbers(&sizes, &parts);
        else if (k == 4) fine = rows(P, &n, &width);
        else fine = numbers(&P->o, &targets);
        if (!fine) { free(sizes); return 0; }
    } while (take(','));
    P->n = n, P->d = width, P->m = parts;
    P->sizes = calloc((size_t)parts + 1, sizeof(int));
    for (int i = 0; i < parts; i++) {
        P->sizes[i] = sizes[i] >= 1 && sizes[i] <= 1e9 ? (int)sizes[i] : 0;
        if (P->sizes[i] < 1 || (REAL)P->sizes[i] != sizes[i]) fail("a modality must have a whole number >= 1 of columns");
        total += P->sizes[i];
    }
    free(sizes);
    if (!take('}')) return fail("the object has no end");
    blank();
    if (*at && *at != '\n') return fail("there is text behind the object");
    for (int k = 0; k < 9; k++) if (!seen[k]) return fail("a key is missing");
    if (width < 1) return fail("X has no columns");
    if (told[0] != n || told[1] != width) return fail("n and d must be what X has");
    if (targets != width) return fail("o must have as many numbers as X has columns");
    if (total != width) return fail("the modalities must add up to the columns of X");
    for (int k = 0; k < 3; k++) if (P->lambda[k] < 0) return fail("a lambda must be >= 0");
    return !why;
}

/* ---------------------------------------------------------------- writing */

static void list(const char *name, int count, const REAL *values) {
    printf(", \"%s\": [", name);
    for (int i = 0; i < count; i++) printf("%s%.17g", i ? ", " : "", (double)values[i]);
    printf("]");
}

static char *line(void) { /* the next line of any length; NULL at the end */
    size_t room = 1 << 16, used = 0;
    char *found = malloc(room);
    while (fgets(found + used, (int)(room - used), stdin)) {
        used += strlen(found + used);
        if (found[used - 1] == '\n') return found;
        if (room - used < 2) found = realloc(found, room *= 2);
    }
    if (used) return found;
    free(found);
    return NULL;
}

int main(void) {
    for (char *read; (read = line()); free(read)) {
        Problem P = {0};
        at = read, why = NULL, id = NULL;
        if (request(&P)) {
            REAL *w = calloc((size_t)P.n, sizeof(REAL)), *u = calloc((size_t)P.d, sizeof(REAL));
            solve(&P, w, u);
            printf("{\"id\": %s", id);
            list("w", P.n, w);
            list("u", P.d, u);
            printf("}\n");
            free(w), free(u);
        } else {
            printf("{\"id\": %s, \"error\": \"%s\"}\n", id ? id : "null", why);
        }
        fflush(stdout);
        free(P.X), free(P.o), free(P.sizes), free(id);
    }
    return 0;
}
