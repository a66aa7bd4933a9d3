#include "tests/support/counted_new.h"

#include <cstdlib>
#include <new>

namespace stof::test {

constinit std::atomic<int> allocations{0};

}  // namespace stof::test

namespace {

// Not inlined: g++ 12 takes free() of what `new` returned for a mistake where it sees one half
// only.
[[gnu::noinline]] void give_back(void* memory) noexcept { std::free(memory); }

}  // namespace

void* operator new(std::size_t size) {
  ++stof::test::allocations;
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) {
    return memory;
  }
  std::abort();
}
void operator delete(void* memory) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { give_back(memory); }
