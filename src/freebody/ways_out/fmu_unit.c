/* A co-simulation unit of FMI 2.0 around freebody's rk4_step. Before it come NQ, NV, GUID and STEP, and the
   function rk4_step. Variables by their value references: 0: the longest step; then NQ positions, NV rates, NV
   torques. */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define FMI2_EXPORT __declspec(dllexport)
#else
#define FMI2_EXPORT __attribute__((visibility("default")))
#endif

typedef void *Component;
typedef double Real;
typedef int Integer;
typedef int Boolean;
typedef const char *String;
typedef unsigned int Reference;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;

enum { COUNT = 1 + NQ + 2*NV, Q = 1, QD = 1 + NQ, TAU = 1 + NQ + NV };

typedef struct {
    Real values[COUNT];
    Real time;
} Unit;

static const Real START[COUNT] = {STARTS};

FMI2_EXPORT String fmi2GetTypesPlatform(void) { return "default"; }
FMI2_EXPORT String fmi2GetVersion(void) { return "2.0"; }

FMI2_EXPORT Component fmi2Instantiate(String name, int kind, String guid, String resources,
                                      const void *callbacks, Boolean visible, Boolean logging)
{
    (void)name; (void)resources; (void)callbacks; (void)visible; (void)logging;
    if (kind != 1 || guid == NULL || strcmp(guid, GUID) != 0) {
        return NULL;
    }
    Unit *unit = malloc(sizeof *unit);
    if (unit != NULL) {
        memcpy(unit->values, START, sizeof START);
        unit->time = 0.0;
    }
    return unit;
}

FMI2_EXPORT void fmi2FreeInstance(Component c) { free(c); }

FMI2_EXPORT Status fmi2SetDebugLogging(Component c, Boolean on, size_t n, const String names[])
{
    (void)c; (void)on; (void)n; (void)names;
    return OK;
}

FMI2_EXPORT Status fmi2SetupExperiment(Component c, Boolean bounded, Real tolerance, Real start,
                                       Boolean ends, Real stop)
{
    (void)bounded; (void)tolerance; (void)ends; (void)stop;
    ((Unit *)c)->time = start;
    return OK;
}

FMI2_EXPORT Status fmi2EnterInitializationMode(Component c) { (void)c; return OK; }
FMI2_EXPORT Status fmi2ExitInitializationMode(Component c) { (void)c; return OK; }
FMI2_EXPORT Status fmi2Terminate(Component c) { (void)c; return OK; }

FMI2_EXPORT Status fmi2Reset(Component c)
{
    memcpy(((Unit *)c)->values, START, sizeof START);
    return OK;
}

FMI2_EXPORT Status fmi2GetReal(Component c, const Reference refs[], size_t n, Real values[])
{
    for (size_t i = 0; i < n; i++) {
        if (refs[i] >= COUNT) {
            return ERROR;
        }
        values[i] = ((Unit *)c)->values[refs[i]];
    }
    return OK;
}

FMI2_EXPORT Status fmi2SetReal(Component c, const Reference refs[], size_t n, const Real values[])
{
    for (size_t i = 0; i < n; i++) {
        if (refs[i] >= COUNT || (refs[i] == 0 && !(values[i] > 0.0))) {
            return ERROR;
        }
        ((Unit *)c)->values[refs[i]] = values[i];
    }
    return OK;
}

/* There are only numbers: of other types none can be asked for. */
#define NONE(function, type) \
    FMI2_EXPORT Status function(Component c, const Reference refs[], size_t n, type values[]) \
    { (void)c; (void)refs; (void)values; return n ? ERROR : OK; }
NONE(fmi2GetInteger, Integer)
NONE(fmi2GetBoolean, Boolean)
NONE(fmi2GetString, String)
NONE(fmi2SetInteger, const Integer)
NONE(fmi2SetBoolean, const Boolean)
NONE(fmi2SetString, const String)

FMI2_EXPORT Status fmi2DoStep(Component c, Real now, Real length, Boolean final)
{
    (void)final;
    Unit *unit = c;
    Real *x = unit->values;
    const Real pieces = ceil(length/x[0] - 1e-9);
    const long long count = pieces > 1.0 ? (long long)pieces : 1;
    for (long long k = 0; k < count; k++) {
        if (STEP(x + Q, x + QD, x + TAU, length/(Real)count, x + Q, x + QD) != 0) {
            return ERROR;
        }
    }
    unit->time = now + length;
    return OK;
}

FMI2_EXPORT Status fmi2CancelStep(Component c) { (void)c; return ERROR; }

FMI2_EXPORT Status fmi2GetFMUstate(Component c, void **state)
{
    if (*state == NULL) {
        *state = malloc(sizeof(Unit));
    }
    if (*state == NULL) {
        return ERROR;
    }
    memcpy(*state, c, sizeof(Unit));
    return OK;
}

FMI2_EXPORT Status fmi2SetFMUstate(Component c, void *state)
{
    memcpy(c, state, sizeof(Unit));
    return OK;
}

FMI2_EXPORT Status fmi2FreeFMUstate(Component c, void **state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return OK;
}

FMI2_EXPORT Status fmi2SerializedFMUstateSize(Component c, void *state, size_t *size)
{
    (void)c; (void)state;
    *size = sizeof(Unit);
    return OK;
}

FMI2_EXPORT Status fmi2SerializeFMUstate(Component c, void *state, char bytes[], size_t size)
{
    (void)c;
    if (size < sizeof(Unit)) {
        return ERROR;
    }
    memcpy(bytes, state, sizeof(Unit));
    return OK;
}

FMI2_EXPORT Status fmi2DeSerializeFMUstate(Component c, const char bytes[], size_t size, void **state)
{
    (void)c;
    if (size < sizeof(Unit) || (*state == NULL && (*state = malloc(sizeof(Unit))) == NULL)) {
        return ERROR;
    }
    memcpy(*state, bytes, sizeof(Unit));
    return OK;
}

FMI2_EXPORT Status fmi2GetDirectionalDerivative(Component c, const Reference z[], size_t nz,
                                                const Reference v[], size_t nv, const Real dv[],
                                                Real dz[])
{
    (void)c; (void)z; (void)nz; (void)v; (void)nv; (void)dv; (void)dz;
    return ERROR;
}

FMI2_EXPORT Status fmi2SetRealInputDerivatives(Component c, const Reference refs[], size_t n,
                                               const Integer order[], const Real values[])
{
    (void)c; (void)refs; (void)order; (void)values;
    return n ? ERROR : OK;
}

FMI2_EXPORT Status fmi2GetRealOutputDerivatives(Component c, const Reference refs[], size_t n,
                                                const Integer order[], Real values[])
{
    (void)c; (void)refs; (void)order; (void)values;
    return n ? ERROR : OK;
}

#define STATUS(function, type) \
    FMI2_EXPORT Status function(Component c, int kind, type *value) \
    { (void)c; (void)kind; (void)value; return DISCARD; }
STATUS(fmi2GetStatus, Status)
STATUS(fmi2GetIntegerStatus, Integer)
STATUS(fmi2GetBooleanStatus, Boolean)
STATUS(fmi2GetStringStatus, String)

FMI2_EXPORT Status fmi2GetRealStatus(Component c, int kind, Real *value)
{
    if (kind != 2) {
        return DISCARD;
    }
    *value = ((Unit *)c)->time;
    return OK;
}
