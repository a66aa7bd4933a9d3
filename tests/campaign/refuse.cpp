// A system that refuses, for programs that are started with this before their libraries
// (LD_PRELOAD). The environment says what:
//   STOF_REFUSE=CALL:ERRNO:FIRST[:COUNT]  the calls FIRST .. FIRST + COUNT - 1, counted from 0,
//   fail;
//                                         without COUNT all from FIRST on
//   STOF_REFUSE_WHEN=FILE                 only while FILE exists; calls are counted from then on
//   STOF_REFUSE_LOG=FILE                  at the end: how many calls there were
// CALL: memory, thread, open, socket, write (of files and their names: write, fsync, rename).
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* at, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
}

namespace {

struct Order {
  char call[16] = {};
  int error = 0;
  long first = 0;
  long count = 0;  // 0: for ever
};

Order order;
const char* when = nullptr;
std::atomic<long> calls{0};

// Before main(), and before the calls of it are counted.
[[gnu::constructor]] void read_order() {
  if (const char* const text = std::getenv("STOF_REFUSE"); text != nullptr) {
    std::sscanf(text, "%15[a-z]:%d:%ld:%ld", order.call, &order.error, &order.first, &order.count);
  }
  when = std::getenv("STOF_REFUSE_WHEN");
  calls = 0;
}

[[gnu::destructor]] void write_count() {
  if (const char* const name = std::getenv("STOF_REFUSE_LOG"); name != nullptr) {
    order.call[0] = '\0';
    if (std::FILE* const file = std::fopen(name, "w"); file != nullptr) {
      std::fprintf(file, "%ld\n", calls.load());
      std::fclose(file);
    }
  }
}

bool refuses(const char* call) {
  if (std::strcmp(order.call, call) != 0 || (when != nullptr && access(when, F_OK) != 0)) {
    return false;
  }
  const long number = calls++;
  if (number < order.first || (order.count > 0 && number >= order.first + order.count)) {
    return false;
  }
  errno = order.error;
  return true;
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

void* malloc(size_t size) { return refuses("memory") ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) {
  return refuses("memory") ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* at, size_t size) {
  return refuses("memory") ? nullptr : __libc_realloc(at, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  return refuses("memory") ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** at, size_t alignment, size_t size) {
  if (refuses("memory")) {
    return ENOMEM;
  }
  *at = __libc_memalign(alignment, size);
  return *at == nullptr ? ENOMEM : 0;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                   void* argument) {
  static const auto real = next<decltype(&pthread_create)>("pthread_create");
  return refuses("thread") ? order.error : real(thread, attributes, start, argument);
}

int socket(int domain, int type, int protocol) {
  static const auto real = next<decltype(&socket)>("socket");
  return refuses("socket") ? -1 : real(domain, type, protocol);
}

int open(const char* name, int flags, ...) {
  static const auto real = next<int (*)(const char*, int, ...)>("open");
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return refuses("open") ? -1 : real(name, flags, mode);
}

ssize_t write(int file, const void* bytes, size_t count) {
  static const auto real = next<decltype(&write)>("write");
  struct stat what{};
  const bool regular = file > 2 && fstat(file, &what) == 0 && S_ISREG(what.st_mode);
  return regular && refuses("write") ? -1 : real(file, bytes, count);
}

int fsync(int file) {
  static const auto real = next<decltype(&fsync)>("fsync");
  return refuses("write") ? -1 : real(file);
}

int rename(const char* from, const char* to) {
  static const auto real = next<decltype(&rename)>("rename");
  return refuses("write") ? -1 : real(from, to);
}
}
