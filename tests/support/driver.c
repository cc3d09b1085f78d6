/* NVIDIA's driver as far as a call of an entry needs it, on this processor: memory is the host's, a launch runs the
   entries that are linked beside it, thread by thread. COUNT: 64-bit values that an entry takes; VALUES(x): x(0), x(1), …
   of each. What a real driver would refuse is refused: memory that was never given, too many threads, no module. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef unsigned int u32;
extern void place(int32_t thread, int32_t threads, int32_t block);
static int ready, context, module;
#define ROOM 64
static char *begin[ROOM];
static size_t size[ROOM];
static int used;

static int held(const char *at, size_t bytes)
{
    for (int k = 0; k < used; k++) {
        if (begin[k] <= at && at + bytes <= begin[k] + size[k]) {
            return 1;
        }
    }
    return 0;
}

int cuInit(u32 flags) { ready = flags == 0; return !ready; }
int cuDeviceGet(int *device, int number) { *device = number; return ready ? number != 0 : 3; }
int cuDevicePrimaryCtxRetain(void **made, int device) { *made = &context; return device; }
int cuCtxSetCurrent(void *given) { context = given == &context; return !context; }
int cuCtxSynchronize(void) { return context ? 0 : 201; }

int cuMemAlloc_v2(uint64_t *address, size_t bytes)
{
    if (!context || !bytes || used == ROOM) {
        return 201;
    }
    begin[used] = malloc(bytes);
    memset(begin[used], 0x7f, bytes);
    size[used] = bytes;
    *address = (uint64_t)(uintptr_t)begin[used++];
    return 0;
}

int cuMemcpyHtoD_v2(uint64_t to, const void *from, size_t bytes)
{
    if (!held((char *)(uintptr_t)to, bytes)) {
        return 1;
    }
    memcpy((void *)(uintptr_t)to, from, bytes);
    return 0;
}

int cuMemcpyDtoH_v2(void *to, uint64_t from, size_t bytes)
{
    if (!held((char *)(uintptr_t)from, bytes)) {
        return 1;
    }
    memcpy(to, (void *)(uintptr_t)from, bytes);
    return 0;
}

int cuModuleLoadData(void **made, const char *text)
{
    *made = &module;
    module = strstr(text, ".target sm_70") != NULL && strstr(text, ".visible .entry") != NULL;
    return context && module ? 0 : 218;
}

int cuModuleGetFunction(void **entry, void *given, const char *name)
{
    Dl_info here;
    dladdr((void *)cuInit, &here);
    void *self = dlopen(here.dli_fname, RTLD_NOW | RTLD_NOLOAD);
    *entry = given == &module ? dlsym(self, name) : NULL;
    return *entry ? 0 : 500;
}

#define TYPE(k) int64_t
#define VALUE(k) *(int64_t *)values[k]
int cuLaunchKernel(void *entry, u32 gx, u32 gy, u32 gz, u32 bx, u32 by, u32 bz, u32 shared, void *stream,
                   void **values, void **extra)
{
    if (!context || !gx || gy != 1 || gz != 1 || !bx || bx > 1024 || by != 1 || bz != 1 || shared || extra) {
        return 1;
    }
    (void)stream;
    for (u32 block = 0; block < gx; block++) {
        for (u32 thread = 0; thread < bx; thread++) {
            place((int32_t)thread, (int32_t)bx, (int32_t)block);
            ((void (*)(VALUES(TYPE)))entry)(VALUES(VALUE));
        }
    }
    return 0;
}
