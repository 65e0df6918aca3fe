/* A third-party FMU for the tests: a spring beside a spring in series with a dashpot (standard linear solid).
 * It shares no code and no names with poropunch, has its own units (mm, mN) and takes no input derivatives.
 * FMI 2.0 co-simulation, only what an importer has to call. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void (*logger_t)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    logger_t logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *step_finished;
    void *environment;
} callbacks_t;

enum { INDENT, LOAD, K_SLOW, K_FAST, TAU, K_LIMIT, DELAY_MS, CREEP, COUNT };
enum { OK = 0, ERROR = 3 };

typedef struct {
    double value[COUNT];
    double fast;   /* force of the branch */
    double last;   /* indentation at the end of the last step */
    callbacks_t callbacks;
    char name[64];
} solid_t;

static void start(solid_t *s) {
    static const double values[COUNT] = {0, 0, 4, 6, 2, 1e9, 0, 0};
    memcpy(s->value, values, sizeof values);
    s->fast = s->last = 0;
}

static int fail(solid_t *s, const char *why) {
    if (s->callbacks.logger) s->callbacks.logger(s->callbacks.environment, s->name, ERROR, "logStatusError", why);
    return ERROR;
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const callbacks_t *callbacks, int visible, int logging) {
    (void)resources, (void)visible, (void)logging;
    if (type != 1 || strcmp(guid, "{third-party-solid}") != 0) return NULL;
    solid_t *s = calloc(1, sizeof *s);
    s->callbacks = *callbacks;
    strncpy(s->name, name, sizeof s->name - 1);
    start(s);
    return s;
}
void fmi2FreeInstance(void *s) { free(s); }
int fmi2SetupExperiment(void *s, int a, double b, double c, int d, double e) {
    (void)s, (void)a, (void)b, (void)c, (void)d, (void)e;
    return OK;
}
int fmi2EnterInitializationMode(void *s) { (void)s; return OK; }
int fmi2ExitInitializationMode(void *c) {
    solid_t *s = c;
    s->last = fmax(s->value[INDENT], 0);
    return OK;
}
int fmi2Terminate(void *s) { (void)s; return OK; }
int fmi2Reset(void *s) { start(s); return OK; }

int fmi2GetReal(void *c, const unsigned *r, size_t n, double *v) {
    solid_t *s = c;
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= COUNT) return fail(s, "unknown variable");
        v[i] = s->value[r[i]];
    }
    return OK;
}
int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *v) {
    solid_t *s = c;
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= COUNT) return fail(s, "unknown variable");
        s->value[r[i]] = v[i];
    }
    return OK;
}
int fmi2GetInteger(void *s, const unsigned *r, size_t n, int *v) { (void)s, (void)r, (void)v; return n ? ERROR : OK; }
int fmi2SetInteger(void *s, const unsigned *r, size_t n, const int *v) { (void)s, (void)r, (void)v; return n ? ERROR : OK; }
int fmi2GetBoolean(void *s, const unsigned *r, size_t n, int *v) { (void)s, (void)r, (void)v; return n ? ERROR : OK; }
int fmi2SetBoolean(void *s, const unsigned *r, size_t n, const int *v) { (void)s, (void)r, (void)v; return n ? ERROR : OK; }

/* The indentation jumps to its new value at the middle of the step: second order for an input held there. */
int fmi2DoStep(void *c, double time, double step, int no_prior) {
    (void)no_prior;
    solid_t *s = c;
    if (!(step > 0)) return fail(s, "step size is not positive");
    if (s->value[K_SLOW] > s->value[K_LIMIT]) return fail(s, "the slow spring is too stiff for this solver");
    if (s->value[DELAY_MS] > 0) usleep((useconds_t)(1000 * s->value[DELAY_MS]));
    double indent = fmax(s->value[INDENT], 0), decay = exp(-step / s->value[TAU]), half = sqrt(decay);
    s->fast = s->fast * decay + s->value[K_FAST] * (indent - s->last) * half;
    s->last = indent;
    s->value[LOAD] = s->value[K_SLOW] * indent + s->fast + s->value[CREEP] * (time + step);
    return OK;
}
