#include <cstddef>
#include <cstdint>
#include <span>

#include "tests/fuzz/fuzz_input.h"

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it by this name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  stof::fuzz::run(std::as_bytes(std::span(data, size)));
  return 0;
}
