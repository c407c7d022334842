/* Kills its process behind the n-th call that makes or changes a file of shared memory, to be preloaded:
   KILL_CALL names the call, or "any"; KILL_AT says which; with KILL_STOPS the process is stopped instead. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#define REAL(name) \
    static __typeof__(name) *real; \
    if (!real) \
        real = dlsym(RTLD_NEXT, #name)

static int is_ours(const char *path)
{
    return path && (strstr(path, "iceoryx2") || strstr(path, "iox2"));
}

static int is_our_file(int file)
{
    char link[64], path[512];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length <= 0)
        return 0;
    path[length] = 0;
    return is_ours(path);
}

static void done(const char *call)
{
    static int calls;
    const char *wanted = getenv("KILL_CALL"), *at = getenv("KILL_AT");
    if (!wanted || !at || (strcmp(wanted, call) && strcmp(wanted, "any")))
        return;
    if (__sync_add_and_fetch(&calls, 1) == atoi(at)) {
        dprintf(2, "reached\n");
        int stops = getenv("KILL_STOPS") != 0;
        kill(getpid(), stops ? SIGSTOP : SIGKILL);
        /* Another thread may be the first to stop. */
        do
            sleep(1);
        while (!stops);
    }
}

int shm_open(const char *name, int how, mode_t mode)
{
    REAL(shm_open);
    int file = real(name, how, mode);
    if (how & O_CREAT)
        done("shm_open");
    return file;
}

int shm_unlink(const char *name)
{
    REAL(shm_unlink);
    int failed = real(name);
    done("unlink");
    return failed;
}

#define ON_OPEN(name) \
    int name(const char *path, int how, ...) \
    { \
        REAL(name); \
        mode_t mode = 0; \
        if (how & O_CREAT) { \
            va_list more; \
            va_start(more, how); \
            mode = va_arg(more, mode_t); \
            va_end(more); \
        } \
        int file = real(path, how, mode); \
        if ((how & O_CREAT) && is_ours(path)) \
            done("open"); \
        return file; \
    }

ON_OPEN(open)
ON_OPEN(open64)

#define ON_FILE(name, call, declared, passed) \
    int name declared \
    { \
        REAL(name); \
        int failed = real passed; \
        if (is_our_file(file)) \
            done(call); \
        return failed; \
    }

#define ON_PATH(name, call, declared, passed) \
    int name declared \
    { \
        REAL(name); \
        int failed = real passed; \
        if (is_ours(path)) \
            done(call); \
        return failed; \
    }

ON_FILE(ftruncate, "ftruncate", (int file, off_t length), (file, length))
ON_FILE(ftruncate64, "ftruncate", (int file, off64_t length), (file, length))
ON_FILE(fchmod, "fchmod", (int file, mode_t mode), (file, mode))
ON_FILE(fsync, "fsync", (int file), (file))
ON_PATH(chmod, "fchmod", (const char *path, mode_t mode), (path, mode))
ON_PATH(mkdir, "mkdir", (const char *path, mode_t mode), (path, mode))
ON_PATH(rename, "rename", (const char *path, const char *to), (path, to))
ON_PATH(unlink, "unlink", (const char *path), (path))
ON_PATH(remove, "unlink", (const char *path), (path))
ON_PATH(rmdir, "unlink", (const char *path), (path))

ssize_t write(int file, const void *bytes, size_t count)
{
    REAL(write);
    ssize_t written = real(file, bytes, count);
    if (is_our_file(file))
        done("write");
    return written;
}
