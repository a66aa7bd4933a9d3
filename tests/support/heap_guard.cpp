#include "tests/support/heap_guard.h"

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <new>

namespace stof::test {

constinit std::atomic<int> allocations{0};
constinit thread_local volatile bool heap_forbidden = false;

}  // namespace stof::test

namespace {

void allocated(const char* how) {
  ++stof::test::allocations;
  if (stof::test::heap_forbidden) {
    stof::test::heap_forbidden = false;
    std::fprintf(stderr, "a thread that must not allocates: %s\n", how);
    std::abort();
  }
}

}  // namespace

// NOLINTBEGIN(readability-identifier-naming): names that the linker makes
extern "C" {
void* __real_malloc(std::size_t size);
void* __real_calloc(std::size_t count, std::size_t size);
void* __real_realloc(void* at, std::size_t size);
void* __real_aligned_alloc(std::size_t alignment, std::size_t size);
int __real_posix_memalign(void** at, std::size_t alignment, std::size_t size);

void* __wrap_malloc(std::size_t size) {
  allocated("malloc");
  return __real_malloc(size);
}
void* __wrap_calloc(std::size_t count, std::size_t size) {
  allocated("calloc");
  return __real_calloc(count, size);
}
void* __wrap_realloc(void* at, std::size_t size) {
  allocated("realloc");
  return __real_realloc(at, size);
}
void* __wrap_aligned_alloc(std::size_t alignment, std::size_t size) {
  allocated("aligned_alloc");
  return __real_aligned_alloc(alignment, size);
}
int __wrap_posix_memalign(void** at, std::size_t alignment, std::size_t size) {
  allocated("posix_memalign");
  return __real_posix_memalign(at, alignment, size);
}
}
// NOLINTEND(readability-identifier-naming)

namespace {

void* take(std::size_t size, std::size_t alignment) noexcept {
  allocated("operator new");
  void* at = nullptr;
  return __real_posix_memalign(&at, alignment, size == 0 ? 1 : size) == 0 ? at : nullptr;
}
void* take_or_abort(std::size_t size, std::size_t alignment) noexcept {
  void* const at = take(size, alignment);
  if (at == nullptr) {
    std::abort();
  }
  return at;
}
constexpr std::size_t kUsual = __STDCPP_DEFAULT_NEW_ALIGNMENT__;
using Align = std::align_val_t;

// Not inlined: g++ 12 takes free() of what `new` returned for a mistake where it sees one half
// only.
[[gnu::noinline]] void give_back(void* at) noexcept { std::free(at); }

}  // namespace

// All forms: a sanitizer brings its own of those that are left out.
void* operator new(std::size_t n) { return take_or_abort(n, kUsual); }
void* operator new[](std::size_t n) { return take_or_abort(n, kUsual); }
void* operator new(std::size_t n, const std::nothrow_t&) noexcept { return take(n, kUsual); }
void* operator new[](std::size_t n, const std::nothrow_t&) noexcept { return take(n, kUsual); }
void* operator new(std::size_t n, Align a) { return take_or_abort(n, static_cast<std::size_t>(a)); }
void* operator new[](std::size_t n, Align a) {
  return take_or_abort(n, static_cast<std::size_t>(a));
}
void operator delete(void* at) noexcept { give_back(at); }
void operator delete[](void* at) noexcept { give_back(at); }
void operator delete(void* at, std::size_t) noexcept { give_back(at); }
void operator delete[](void* at, std::size_t) noexcept { give_back(at); }
void operator delete(void* at, const std::nothrow_t&) noexcept { give_back(at); }
void operator delete[](void* at, const std::nothrow_t&) noexcept { give_back(at); }
void operator delete(void* at, Align) noexcept { give_back(at); }
void operator delete[](void* at, Align) noexcept { give_back(at); }
void operator delete(void* at, std::size_t, Align) noexcept { give_back(at); }
void operator delete[](void* at, std::size_t, Align) noexcept { give_back(at); }
