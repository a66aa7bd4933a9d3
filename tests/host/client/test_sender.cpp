// Sends frames of random pixels to a port of this machine, their packets shuffled and among
// damaged, doubled and foreign ones, and prints what a receiver must see:
//   wire_test_sender PORT FRAMES
// After each frame it waits for a line on stdin: nothing depends on speed.
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/wire/crc32c.h"
#include "tests/firmware/wire/wire_support.h"
#include "tests/host/client/loopback_sender.h"

namespace stof::test {
namespace {

constexpr int kWidth = 161;
constexpr int kHeight = 120;
constexpr std::uint32_t kFirstNumber = 0xFFFFFFF0;  // wraps on the way

template <typename T>
std::uint32_t checksum(dsp::ImageView<const T> image, std::uint32_t before) {
  for (int y = 0; y < image.height(); ++y) {
    before = wire::crc32c(std::as_bytes(image.row(y)), before);
  }
  return before;
}

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
  KeepingSink sink;
  wire::Packetizer stranger({.device_id = 1, .session_id = 1}, sink);
  static_cast<void>(stranger.publish({}, {}, {}));
  return {damaged, cut, other, sink.sent.front()};
}

bool send_frame(LoopbackSender& sender, std::uint32_t frame) {
  RandomMap map(kWidth, kHeight, frame);
  const dsp::DepthMap view = map.view();
  KeepingSink sink;
  wire::Packetizer packetizer(kOrigin, sink);
  const wire::FrameStamp stamp{.number = kFirstNumber + frame, .freshness = 1 + frame};
  if (packetizer.publish(stamp, {}, view).status != Status::kOk) {
    return false;
  }
  Random random(frame);
  std::vector<Datagram>& packets = sink.sent;
  const std::size_t count = packets.size();
  shuffle(packets, random);
  const std::vector<Datagram> around = noise(packets.back(), random);
  packets.insert(packets.begin() + 1, around.begin(), around.end());
  packets.insert(packets.begin() + 1, packets.front());
  for (const Datagram& packet : packets) {
    if (sender.send(packet) != Status::kOk) {
      return false;
    }
  }
  const std::uint32_t crc = checksum<dsp::Source>(
      view.source, checksum<dsp::QuarterMm>(view.width, checksum<dsp::QuarterMm>(view.depth, 0)));
  std::printf("frame %u %dx%d packets %zu/%zu crc %08x\n", stamp.number, kWidth, kHeight, count,
              count, crc);
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
