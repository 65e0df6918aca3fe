/* Loads an FMU's library as hosts in C do and makes a test with it, on whatever platform it was compiled for.
 *
 * host LIBRARY GUID STEPS SIZE REFERENCE...     references of mesh.preset, solver.sensitivities, then of the Reals to print
 *
 * Prints time and the Reals after each of STEPS steps of SIZE s. At half of them the state is serialised, one step made,
 * the state restored from its bytes and the step made again: the same bits. A wrong value must be refused with a message
 * that comes through the variadic logger.
 */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
static const char *load_error(void) { static char text[32]; snprintf(text, sizeof text, "error %lu", GetLastError()); return text; }
#else
#include <dlfcn.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
static const char *load_error(void) { return dlerror(); }
#endif

typedef void *Component;
typedef unsigned Reference;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static char heard[4096];

static void logger(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    va_list arguments;
    (void)environment, (void)instance, (void)status, (void)category;
    va_start(arguments, message);
    vsnprintf(heard, sizeof heard, message, arguments);
    va_end(arguments);
}

static void demand(int good, const char *what) {
    if (!good) {
        fprintf(stderr, "%s failed: %s\n", what, heard);
        exit(1);
    }
}

static void *library;

static void *function(const char *name) {
    void *found = find(library, name);
    demand(found != NULL, name);
    return found;
}

#define CALL(name, signature, ...) (((int(*) signature)function(name))(__VA_ARGS__))

static void step(Component c, double time, double size) {
    demand(CALL("fmi2DoStep", (Component, double, double, int), c, time, size, 1) == 0, "fmi2DoStep");
}

static void get(Component c, const Reference *references, size_t n, double *values) {
    demand(CALL("fmi2GetReal", (Component, const Reference *, size_t, double *), c, references, n, values) == 0, "fmi2GetReal");
}

int main(int count, char **arguments) {
    static const Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    Reference references[64];
    double values[64], again[64], size, bad = 2.0;
    int steps, n, one = 1, sensitivities = 1;
    Component c;

    if (count < 8) return 2;
    library = load(arguments[1]);
    if (library == NULL) snprintf(heard, sizeof heard, "%s", load_error());
    demand(library != NULL, "loading");
    steps = atoi(arguments[3]);
    size = atof(arguments[4]);
    for (n = 0; n + 5 < count && n < 64; n++) references[n] = (Reference)strtoul(arguments[n + 5], NULL, 10);
    n -= 3;

    c = ((Component(*)(const char *, int, const char *, const char *, const Callbacks *, int, int))function("fmi2Instantiate"))(
        "host", 1, arguments[2], "file:///resources", &callbacks, 0, 0);
    demand(c != NULL, "fmi2Instantiate");
    demand(CALL("fmi2SetInteger", (Component, const Reference *, size_t, const int *), c, references, 1, &one) == 0, "fmi2SetInteger");
    demand(CALL("fmi2SetBoolean", (Component, const Reference *, size_t, const int *), c, references + 1, 1, &sensitivities) == 0, "fmi2SetBoolean");
    /* The third reference is that of material.n0s, which is below 1. */
    demand(CALL("fmi2SetReal", (Component, const Reference *, size_t, const double *), c, references + 2, 1, &bad) != 0, "refusal");
    demand(strstr(heard, "is outside") != NULL, "the message of the refusal");
    demand(CALL("fmi2SetupExperiment", (Component, int, double, double, int, double), c, 0, 0.0, 0.0, 0, 0.0) == 0, "fmi2SetupExperiment");
    demand(CALL("fmi2EnterInitializationMode", (Component), c) == 0, "fmi2EnterInitializationMode");
    demand(CALL("fmi2ExitInitializationMode", (Component), c) == 0, "fmi2ExitInitializationMode");

    for (int k = 0; k < steps; k++) {
        if (k == steps / 2) {
            void *state = NULL;
            size_t bytes = 0;
            unsigned char *kept;
            demand(CALL("fmi2GetFMUstate", (Component, void **), c, &state) == 0, "fmi2GetFMUstate");
            demand(CALL("fmi2SerializedFMUstateSize", (Component, void *, size_t *), c, state, &bytes) == 0, "its size");
            kept = malloc(bytes);
            demand(CALL("fmi2SerializeFMUstate", (Component, void *, unsigned char *, size_t), c, state, kept, bytes) == 0, "serialising");
            demand(CALL("fmi2FreeFMUstate", (Component, void **), c, &state) == 0, "fmi2FreeFMUstate");
            step(c, k * size, size);
            get(c, references + 3, n, again);
            demand(CALL("fmi2DeSerializeFMUstate", (Component, const unsigned char *, size_t, void **), c, kept, bytes, &state) == 0, "deserialising");
            demand(CALL("fmi2SetFMUstate", (Component, void *), c, state) == 0, "fmi2SetFMUstate");
            demand(CALL("fmi2FreeFMUstate", (Component, void **), c, &state) == 0, "fmi2FreeFMUstate");
            free(kept);
        }
        step(c, k * size, size);
        get(c, references + 3, n, values);
        if (k == steps / 2) demand(memcmp(values, again, n * sizeof *values) == 0, "the same bits from a restored state");
        printf("%.17g", (k + 1) * size);
        for (int i = 0; i < n; i++) printf(",%.17g", values[i]);
        printf("\n");
    }
    demand(CALL("fmi2Terminate", (Component), c) == 0, "fmi2Terminate");
    ((void (*)(Component))function("fmi2FreeInstance"))(c);
    return 0;
}
