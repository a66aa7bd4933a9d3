// Sends frames of all eight streams, raw, coded and rounded in turn, to a port of this machine,
// their packets shuffled and among damaged, doubled and foreign ones; one of each frame is lost,
// and parity makes it good. Prints what a receiver must see:
//   wire_test_sender PORT FRAMES
// After each frame it waits for a line on stdin: nothing depends on speed.
#include <array>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/wire/crc32c.h"
#include "tests/host/client/loopback_sender.h"
#include "tests/host/client/test_pattern.h"

namespace stof::test {
namespace {

constexpr PatternSizes kSizes{.width = 161, .height = 120, .pmd_width = 40, .pmd_height = 30};
constexpr std::uint32_t kFirstNumber = 0xFFFFFFF0;  // wraps on the way

void shuffle(std::vector<Datagram>& packets, Random& random) {
  for (std::size_t i = packets.size(); i > 1; --i) {
    const auto other = static_cast<std::size_t>(random.between(0, static_cast<int>(i) - 1));
    std::swap(packets[i - 1], packets[other]);
  }
}

// A damaged copy, a part of one, something else, one of another device.
std::vector<Datagram> noise(const Datagram& packet, Random& random) {
  Datagram damaged = packet;
  damaged[static_cast<std::size_t>(random.between(8, 49))] ^=
      static_cast<std::byte>(1 << random.between(0, 7));
  Datagram cut = packet;
  cut.resize(static_cast<std::size_t>(random.between(0, static_cast<int>(packet.size()) - 1)));
  Datagram other(100, std::byte{0x55});
  Coder stranger({.device_id = 1, .session_id = 1}, {});
  return {damaged, cut, other, stranger.code({}, {}, {}).front()};
}

// The parts of a frame shuffled but one, then its parity, that of the lost one at the end.
std::vector<Datagram> lossy(std::vector<Datagram> packets, std::uint16_t parts, Random& random) {
  const std::uint16_t groups = wire::parity_groups(parts);
  const auto lost = static_cast<std::ptrdiff_t>(random.between(0, parts - 1));
  std::swap(packets[parts + static_cast<std::size_t>(lost % groups)], packets.back());
  std::vector<Datagram> shuffled(packets.begin(), packets.begin() + parts);
  shuffled.erase(shuffled.begin() + lost);
  shuffle(shuffled, random);
  shuffled.insert(shuffled.end(), packets.begin() + parts, packets.end());
  return shuffled;
}

bool send_frame(LoopbackSender& sender, std::uint32_t frame) {
  const FrameSpec spec{.number = kFirstNumber + frame, .freshness = 1 + frame};
  constexpr std::array kCodings{wire::Coding::kRvl, wire::Coding::kRaw, wire::Coding::kQuantised};
  const wire::Coding coding = kCodings[frame % kCodings.size()];
  std::vector<Datagram> packets =
      pattern_datagrams(spec, kSizes, every_stream(coding, true, kSizes.cloud_step));
  const std::uint16_t parts = wire::parse_packet(packets.front())->header.count;
  Random random(frame);
  packets = lossy(std::move(packets), parts, random);
  const std::vector<Datagram> around = noise(packets.front(), random);
  packets.insert(packets.begin() + 1, around.begin(), around.end());
  packets.insert(packets.begin() + 1, packets.front());
  for (const Datagram& packet : packets) {
    if (sender.send(packet) != Status::kOk) {
      return false;
    }
  }
  std::printf(
      "frame %u %dx%d packets %u/%u recovered 1 crc %08x\n", spec.number, kSizes.width,
      kSizes.height, unsigned{parts}, unsigned{parts},
      wire::crc32c(PatternFrame(spec.number, kSizes).bytes(coding == wire::Coding::kQuantised)));
  std::fflush(stdout);
  return std::getchar() != EOF;
}

}  // namespace
}  // namespace stof::test

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: wire_test_sender PORT FRAMES\n");
    return 2;
  }
  std::uint16_t port = 0;
  std::uint32_t frames = 0;
  std::from_chars(argv[1], argv[1] + std::strlen(argv[1]), port);
  std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), frames);
  stof::test::LoopbackSender sender(port);
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    if (!sender.connected() || !stof::test::send_frame(sender, frame)) {
      std::fprintf(stderr, "wire_test_sender: frame %u could not be sent to port %u\n", frame,
                   port);
      return 1;
    }
  }
  std::printf("refused crc %u duplicate %u foreign %u magic %u truncated %u\n", frames, frames,
              frames, frames, frames);
  return 0;
}
