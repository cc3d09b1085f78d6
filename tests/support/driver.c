/* NVIDIA's driver as far as freebody and the self-tests of its packages need it, on this processor: memory is the
   host's, a launch runs the entries one thread after the other, streams do everything at once. What a driver would refuse
   is refused: memory that was never given, blocks that are too large, work without a context.
   An entry is called NAME.packed; it is linked beside this, or found by what `emulate` was given. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef unsigned int u32;
typedef void *(*Resolve)(const char *text, const char *name);
typedef void (*Place)(int32_t thread, int32_t threads, int32_t block);
typedef struct { char *text; } Module;
typedef struct { void (*run)(void **values); Place place; } Entry;

static int ready, depth;
static char primary;
static Resolve resolve;
#define ROOM 4096
static char *begin[ROOM];
static size_t size[ROOM];
static int used, live;

void emulate(Resolve given) { resolve = given; }
int blocks_of_memory(void) { return live; }

static int held(uint64_t address, size_t bytes)
{
    char *at = (char *)(uintptr_t)address;
    for (int k = 0; k < used; k++) {
        if (begin[k] && begin[k] <= at && at + bytes <= begin[k] + size[k]) {
            return depth > 0;
        }
    }
    return 0;
}

int cuInit(u32 flags) { ready = flags == 0; return !ready; }
int cuDriverGetVersion(int *version) { *version = 13000; return 0; }
int cuDeviceGetCount(int *count) { *count = 1; return ready ? 0 : 3; }
int cuDeviceGet(int *device, int number) { *device = number; return !ready ? 3 : number ? 101 : 0; }
int cuDevicePrimaryCtxRetain(void **made, int device) { *made = &primary; return device; }
int cuCtxSetCurrent(void *given) { depth = given == &primary; return !depth; }
int cuCtxPushCurrent_v2(void *given) { depth += given == &primary; return given != &primary; }
int cuCtxPopCurrent_v2(void **given) { *given = &primary; return depth-- < 1; }
int cuCtxSynchronize(void) { return depth > 0 ? 0 : 201; }
int cuStreamSynchronize(void *stream) { return depth > 0 && stream ? 0 : 201; }
int cuEventCreate(void **event, u32 flags) { *event = &primary; return depth > 0 && flags == 2 ? 0 : 201; }
int cuEventRecord(void *event, void *stream) { return event && stream ? 0 : 400; }
int cuStreamWaitEvent(void *stream, void *event, u32 flags) { return event && stream && !flags ? 0 : 400; }
int cuEventDestroy_v2(void *event) { return event == &primary ? 0 : 400; }

int cuPointerGetAttribute(void *value, u32 kind, uint64_t address)
{
    *(int *)value = 0;
    return kind == 9 && held(address, 1) ? 0 : 1;
}

/* 2: kind of memory (2: a device's), 8: whether it is managed, 9: number of the device */
int cuPointerGetAttributes(u32 count, const u32 *kinds, void **values, uint64_t address)
{
    for (u32 k = 0; k < count; k++) {
        *(int *)values[k] = kinds[k] == 2 && held(address, 1) ? 2 : 0;
    }
    return 0;
}

int cuMemAlloc_v2(uint64_t *address, size_t bytes)
{
    if (depth < 1 || !bytes || used == ROOM) {
        return 201;
    }
    begin[used] = malloc(bytes);
    memset(begin[used], 0x7f, bytes);
    size[used] = bytes;
    *address = (uint64_t)(uintptr_t)begin[used++];
    live++;
    return 0;
}

int cuMemAllocAsync(uint64_t *address, size_t bytes, void *stream) { return stream ? cuMemAlloc_v2(address, bytes) : 400; }

int cuMemFreeAsync(uint64_t address, void *stream)
{
    for (int k = 0; k < used; k++) {
        if (begin[k] && begin[k] == (char *)(uintptr_t)address && stream && depth > 0) {
            memset(begin[k], 0x7f, size[k]);
            free(begin[k]);
            begin[k] = NULL;
            live--;
            return 0;
        }
    }
    return 1;
}

static int copy(void *to, const void *from, size_t bytes, int allowed)
{
    if (allowed) {
        memcpy(to, from, bytes);
    }
    return !allowed;
}

#define AT(address) (void *)(uintptr_t)(address)
int cuMemcpyHtoD_v2(uint64_t to, const void *from, size_t n) { return copy(AT(to), from, n, held(to, n)); }
int cuMemcpyDtoH_v2(void *to, uint64_t from, size_t n) { return copy(to, AT(from), n, held(from, n)); }
int cuMemcpyHtoDAsync_v2(uint64_t to, const void *from, size_t n, void *s) { return s ? cuMemcpyHtoD_v2(to, from, n) : 400; }
int cuMemcpyDtoHAsync_v2(void *to, uint64_t from, size_t n, void *s) { return s ? cuMemcpyDtoH_v2(to, from, n) : 400; }
int cuMemcpyDtoDAsync_v2(uint64_t to, uint64_t from, size_t n, void *s)
{
    return copy(AT(to), AT(from), n, s && held(to, n) && held(from, n));
}

int cuModuleLoadData(void **made, const char *text)
{
    Module *module = malloc(sizeof(Module));
    module->text = strdup(text);
    *made = module;
    return depth > 0 && strstr(text, ".target sm_70") && strstr(text, ".visible .entry") ? 0 : 218;
}

int cuModuleUnload(void *module) { free(((Module *)module)->text); free(module); return 0; }

static void *found(const char *text, const char *name)
{
    Dl_info here;
    dladdr((void *)cuInit, &here);
    return resolve ? resolve(text, name) : dlsym(dlopen(here.dli_fname, RTLD_NOW | RTLD_NOLOAD), name);
}

int cuModuleGetFunction(void **made, void *module, const char *name)
{
    char packed[256];
    snprintf(packed, sizeof packed, "%s.packed", name);
    Entry *entry = malloc(sizeof(Entry));
    entry->run = (void (*)(void **))found(((Module *)module)->text, packed);
    entry->place = (Place)found(((Module *)module)->text, "place");
    *made = entry;
    return entry->run && entry->place ? 0 : 500;
}

int cuLaunchKernel(void *given, u32 gx, u32 gy, u32 gz, u32 bx, u32 by, u32 bz, u32 shared, void *stream,
                   void **values, void **extra)
{
    Entry *entry = given;
    (void)stream;
    if (depth < 1 || !gx || gy != 1 || gz != 1 || !bx || bx > 1024 || by != 1 || bz != 1 || shared || extra) {
        return 1;
    }
    for (u32 block = 0; block < gx; block++) {
        for (u32 thread = 0; thread < bx; thread++) {
            entry->place((int32_t)thread, (int32_t)bx, (int32_t)block);
            entry->run(values);
        }
    }
    return 0;
}

/* how NVIDIA's binding finds functions: newer ones of a name end in _v2 */
int cuGetProcAddress_v2(const char *name, void **function, int version, uint64_t flags, int *status)
{
    char newer[256];
    Dl_info here;
    (void)version, (void)flags;
    dladdr((void *)cuInit, &here);
    void *self = dlopen(here.dli_fname, RTLD_NOW | RTLD_NOLOAD);
    snprintf(newer, sizeof newer, "%s_v2", name);
    *function = dlsym(self, newer);
    if (!*function && !strncmp(name, "cu", 2)) {
        *function = dlsym(self, name);
    }
    if (status) {
        *status = !*function;
    }
    return *function ? 0 : 500;
}

int cuGetProcAddress(const char *name, void **function, int version, uint64_t flags)
{
    return cuGetProcAddress_v2(name, function, version, flags, NULL);
}
