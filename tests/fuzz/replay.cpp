// A fuzz target without libFuzzer: runs every file of the folders given, and, of each, COUNT copies
// with a few bytes changed.
//   fuzz_TARGET COUNT FOLDER...
#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string_view>
#include <vector>

#include "tests/fuzz/fuzz_input.h"
#include "tests/support/random.h"

namespace stof {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// What holds each byte ends with the last: one too far is seen by AddressSanitizer.
void run(Bytes bytes) {
  bytes.shrink_to_fit();
  fuzz::run(std::as_bytes(std::span(bytes)));
}

void change(Bytes& bytes, test::Random& random) {
  for (int changes = random.between(1, 4); changes > 0 && !bytes.empty(); --changes) {
    const auto at = static_cast<std::size_t>(random.between(0, static_cast<int>(bytes.size()) - 1));
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (random.between(0, 4)) {
      case 0:
        *place ^= static_cast<std::uint8_t>(1U << random.between(0, 7));
        break;
      case 1:
        *place = static_cast<std::uint8_t>(random.between(0, 255));
        break;
      case 2:
        bytes.erase(place);
        break;
      case 3:
        bytes.insert(place, static_cast<std::uint8_t>(random.between(0, 255)));
        break;
      default:
        bytes.resize(at);
        break;
    }
  }
}

}  // namespace
}  // namespace stof

int main(int argc, char** argv) {
  using namespace stof;
  const std::vector<std::string_view> words(argv + 1, argv + argc);
  int copies = 0;
  if (words.size() < 2 ||
      std::from_chars(words[0].data(), words[0].data() + words[0].size(), copies).ec !=
          std::errc{}) {
    std::fprintf(stderr, "use: %s COUNT FOLDER...\n", argv[0]);
    return 2;
  }
  std::vector<std::filesystem::path> files;
  for (const std::string_view folder : std::span(words).subspan(1)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      files.push_back(entry.path());
    }
  }
  std::ranges::sort(files);
  test::Random random(1);
  for (const std::filesystem::path& file : files) {
    const Bytes seed = read(file);
    run(seed);
    for (int i = 0; i < copies; ++i) {
      Bytes changed = seed;
      change(changed, random);
      run(std::move(changed));
    }
  }
  std::printf("%zu seeds, %d changed copies of each\n", files.size(), copies);
  return files.empty() ? 1 : 0;
}
