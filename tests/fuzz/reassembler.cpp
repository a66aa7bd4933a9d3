#include "host/client/reassembler.h"

#include <array>
#include <chrono>

#include "tests/fuzz/fuzz_input.h"

// Datagrams to a receiver: frames come out whole or marked, every datagram is counted once.
namespace stof {
namespace {

constexpr std::uint32_t kSession = 0x1122'3344;  // of the seeds

constexpr std::size_t kMostPixels = 1 << 12;

template <typename T>
void look_at(dsp::ImageView<const T> image) {
  fuzz::require(image.width() >= 0 && image.height() >= 0);
  for (int y = 0; y < image.height(); ++y) {
    fuzz::touch(std::as_bytes(image.row(y)));
  }
}

void look_at(const client::Frame& frame) {
  look_at(frame.depth);
  look_at(frame.interval_width);
  look_at(frame.source);
  look_at(frame.cause);
  look_at(frame.received);
  look_at(frame.disparity);
  for (const auto& samples : frame.pmd) {
    look_at(samples);
  }
  look_at(frame.left);
  look_at(frame.right);
  look_at(frame.cloud);
  for (const auto& marks : frame.marks) {
    look_at(marks);
  }
  fuzz::require(frame.missing_packets <= frame.packets);
}

void look_at(const client::RawExposure& exposure) {
  look_at(exposure.left);
  look_at(exposure.right);
  for (const auto& sample : exposure.pmd) {
    look_at(sample);
  }
  fuzz::require((exposure.missing & ~exposure.info.pictures) == 0);
  const bool left = (exposure.info.pictures & ~exposure.missing & wire::kRawLeft) != 0;
  fuzz::require(left == !exposure.left.empty());
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  require(wire::start_crypto());
  const bool signs = input.size() % 2 != 0;  // whether streams have to be signed
  const wire::StreamKey key{.number = 1};
  client::StreamVerifier verifier;
  verifier.set_key(key, kSession);
  client::Reassembler reassembler(
      {.max_pixels = kMostPixels, .raw_pictures = true, .verifier = signs ? &verifier : nullptr});
  wire::StreamTagger tagger(key);
  std::uint64_t counter = 0;
  client::Time now{};
  std::uint64_t pushed = 0;
  const auto take_all = [&] {
    while (const std::optional<client::Frame> frame = reassembler.take()) {
      look_at(*frame);
    }
    while (const std::optional<client::RawExposure> exposure = reassembler.raw().take()) {
      look_at(*exposure);
    }
    while (reassembler.take_event()) {
    }
  };
  fuzz::for_each_record(input, [&](const fuzz::Record& record) {
    wire::DatagramBuffer space{};
    const bool seal = (record.flags & fuzz::kSeal) != 0;
    now += std::chrono::milliseconds(20 * record.seconds());
    std::span<const std::byte> datagram = seal ? fuzz::sealed(record.bytes, space) : record.bytes;
    wire::DatagramBuffer signed_space{};
    const auto packet = wire::parse_packet(datagram);
    if (signs && packet && datagram[6] == std::byte{wire::kHeaderBytes} &&
        datagram.size() + wire::kStreamSignatureBytes <= signed_space.size() &&
        record.peer() != 3) {  // else not signed
      counter += 1 + record.seconds();
      datagram = wire::sign_datagram(datagram, tagger, counter - record.peer() / 2, signed_space);
    }
    reassembler.push(datagram, now);
    ++pushed;
    if ((record.flags & fuzz::kCookie) == 0) {
      take_all();
    }
    reassembler.expire(now);
  });
  reassembler.expire(now + std::chrono::seconds(100));
  take_all();
  fuzz::require(reassembler.statistics().packets() == pushed);
}
