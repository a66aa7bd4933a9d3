#include "tests/fuzz/import_file.h"

// Kalibr's camchain.
void stof::fuzz::run(std::span<const std::byte> input) {
  judge(host::parse_kalibr(text_of(input)));
}
