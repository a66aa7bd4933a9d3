#include "host/viewer/client_frames.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tests/fuzz/fuzz_input.h"

// What a browser's end of a WebSocket sends, in parts of any size: the first byte of the input says
// of which. What is passed on is the begin of what came, up to the first frame without a mask and
// never into it, however it was cut.
namespace stof {
namespace {

using Bytes = std::span<const std::uint8_t>;

struct Reference {
  std::size_t passed = 0;  // bytes
  bool refused = false;
};

// RFC 6455, 5.2, of all at once.
Reference read_frames(Bytes all) {
  Reference out;
  while (all.size() - out.passed >= 2) {
    const Bytes frame = all.subspan(out.passed);
    if (frame[1] < 0x80U) {
      out.refused = true;
      return out;
    }
    std::size_t head = 6;
    std::uint64_t size = frame[1] & 0x7FU;
    if (size >= 126) {
      const std::size_t more = size == 126 ? 2 : 8;
      head += more;
      if (frame.size() < head) {
        return out;
      }
      size = 0;
      for (const std::uint8_t byte : frame.subspan(2, more)) {
        size = size << 8U | byte;
      }
    }
    if (frame.size() < head) {
      return out;
    }
    out.passed += head;
    out.passed += static_cast<std::size_t>(std::min<std::uint64_t>(size, frame.size() - head));
  }
  return out;
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  if (input.empty()) {
    return;
  }
  const std::size_t most = 1 + std::to_integer<std::size_t>(input[0]) % 32;
  const Bytes all(reinterpret_cast<const std::uint8_t*>(input.data()) + 1, input.size() - 1);
  viewer::ClientFrames frames;
  std::vector<std::uint8_t> passed;
  bool sound = true;
  for (Bytes left = all; !left.empty();) {
    const Bytes part = left.first(std::min(most, left.size()));
    const bool was = sound;
    sound = frames.take(part, passed);
    require(was || !sound);  // who was refused stays so
    left = left.subspan(part.size());
  }
  const Reference wanted = read_frames(all);
  require(sound == !wanted.refused);
  require(std::ranges::equal(passed, all.first(wanted.passed)));
}
