#include "tests/support/power_cut.h"

#include <cerrno>
#include <cstddef>

#include <sys/types.h>

namespace stof::test {

Power power;

namespace {

// Whether the call still happens.
bool spend() {
  ++power.calls;
  if (power.calls_left == 0) {
    power.cut = true;
  } else if (power.calls_left > 0) {
    --power.calls_left;
  }
  if (power.cut) {
    errno = EIO;
  }
  return !power.cut;
}

}  // namespace
}  // namespace stof::test

using stof::test::power;
using stof::test::spend;

extern "C" {
ssize_t __real_write(int fd, const void* bytes, size_t count);
int __real_rename(const char* from, const char* to);
int __real_unlink(const char* name);

ssize_t __wrap_write(int fd, const void* bytes, size_t count) {
  if (fd <= 2) {
    return __real_write(fd, bytes, count);
  }
  const bool on = spend();
  power.flushed = false;
  if (on) {
    return __real_write(fd, bytes, count);
  }
  static_cast<void>(__real_write(fd, bytes, count / 2));  // torn
  errno = EIO;
  return -1;
}

// What is flushed is kept account of: the medium itself, which may take long, is not asked.
int __wrap_fsync(int /*fd*/) {
  if (!spend()) {
    return -1;
  }
  power.flushed = true;
  return 0;
}

int __wrap_rename(const char* from, const char* to) {
  if (!spend()) {
    return -1;
  }
  if (!power.flushed) {
    power.unflushed = to;
  }
  return __real_rename(from, to);
}

int __wrap_unlink(const char* name) { return spend() ? __real_unlink(name) : -1; }
}
