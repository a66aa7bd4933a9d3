#include <string_view>
#include <vector>

#include "board/emu/write_pair.h"

int main(int argc, char** argv) {
  const std::vector<std::string_view> arguments(argv + 1, argv + argc);
  return stof::board::write_pair(arguments);
}
