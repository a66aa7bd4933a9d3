#pragma once

#include <atomic>

namespace stof::test {

// How often operator new was called. For programs that are linked with counted_new.cpp, which
// replaces it.
extern std::atomic<int> allocations;

}  // namespace stof::test
