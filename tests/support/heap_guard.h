#pragma once

#include <atomic>

// Sees every call of the allocator in a program that is linked with stof_heap_guard, also those of
// the library under test. The linker sends malloc and its like there (--wrap). Operator new of the
// C++ library calls malloc inside that library, where the linker does not reach: so it is replaced.
namespace stof::test {

// How often any thread allocated.
extern constinit std::atomic<int> allocations;

// Whether the calling thread must not: then the program ends and says by what it did.
// volatile: compilers know malloc, and that it reads no variable of ours.
extern constinit thread_local volatile bool heap_forbidden;

}  // namespace stof::test
