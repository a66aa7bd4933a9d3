#include "tests/fuzz/import_file.h"

// OpenCV's FileStorage, YAML or JSON. First byte odd: the size of the pictures is told beside.
void stof::fuzz::run(std::span<const std::byte> input) {
  if (input.empty()) {
    return;
  }
  const bool told = std::to_integer<unsigned>(input[0]) % 2 != 0;
  judge(host::parse_opencv({text_of(input.subspan(1))}, told ? 64 : 0, told ? 48 : 0));
}
