#pragma once

#include <string>

// Power that goes before any call that changes a file. The linker leads write, fsync, rename and
// unlink here: LINKER:--wrap=write,--wrap=fsync,--wrap=rename,--wrap=unlink.
namespace stof::test {

struct Power {
  int calls_left = -1;  // -1: power stays on
  int calls = 0;
  bool cut = false;
  bool flushed = true;      // what was written last
  std::string unflushed{};  // name that rename gave to bytes not flushed yet
};
extern Power power;

}  // namespace stof::test
