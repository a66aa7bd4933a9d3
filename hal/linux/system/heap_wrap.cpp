// The linker sends every call of the allocator through these (--wrap): of this program's own
// objects, and in a static link of all libraries, whose operator new calls malloc.

#include <cerrno>
#include <cstddef>
#include <cstdlib>

#include "hal/linux/system/heap_watch.h"

using stof::hal::linux::note_heap_call;

extern "C" {
void* __real_malloc(std::size_t size);
void* __real_calloc(std::size_t count, std::size_t size);
void* __real_realloc(void* at, std::size_t size);
void* __real_aligned_alloc(std::size_t alignment, std::size_t size);
int __real_posix_memalign(void** at, std::size_t alignment, std::size_t size);
void* __real_memalign(std::size_t alignment, std::size_t size);

void* __wrap_malloc(std::size_t size) {
  note_heap_call();
  return __real_malloc(size);
}
void* __wrap_calloc(std::size_t count, std::size_t size) {
  note_heap_call();
  return __real_calloc(count, size);
}
void* __wrap_realloc(void* at, std::size_t size) {
  note_heap_call();
  return __real_realloc(at, size);
}
void* __wrap_aligned_alloc(std::size_t alignment, std::size_t size) {
  note_heap_call();
  return __real_aligned_alloc(alignment, size);
}
int __wrap_posix_memalign(void** at, std::size_t alignment, std::size_t size) {
  note_heap_call();
  return __real_posix_memalign(at, alignment, size);
}
void* __wrap_memalign(std::size_t alignment, std::size_t size) {
  note_heap_call();
  return __real_memalign(alignment, size);
}
void* __wrap_reallocarray(void* at, std::size_t count, std::size_t size) {
  note_heap_call();
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes)) {
    errno = ENOMEM;
    return nullptr;
  }
  // Not through the C library's own, which in a static link would come by __wrap_realloc again.
  return __real_realloc(at, bytes);
}
}
