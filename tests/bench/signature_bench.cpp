// stof_signature_bench: what the signatures of a stream take, of one datagram and of a second.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "firmware/wire/keys/signed_stream.h"

namespace stof {
namespace {

constexpr int kTurns = 400;
constexpr int kInTurn = 200;
// Of the default streams at 640x480 and 30 Hz, the emulated corridor: scripts/link_bench latency
// prints both.
constexpr double kPackets = 250;
constexpr double kFramesPerSecond = 30;

// The least of many turns: the machine has more to do. ns of one.
template <typename Work>
double least_ns(const Work& work) {
  double least = std::numeric_limits<double>::max();
  for (int turn = 0; turn < kTurns; ++turn) {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < kInTurn; ++i) {
      work();
    }
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begin;
    least = std::min(least, taken.count() / kInTurn);
  }
  return least;
}

void measure(std::size_t bytes) {
  wire::StreamKey key{.number = 1};
  wire::fill_random(key.secret);
  wire::DatagramBuffer plain{};
  wire::DatagramBuffer space{};
  std::span<const std::byte> datagram = wire::seal_packet(
      {}, bytes - wire::kStreamSignatureBytes - wire::kHeaderBytes - wire::kCrcBytes, plain);
  std::uint64_t counter = 0;
  std::span<const std::byte> made;
  unsigned sum = 0;
  const auto keep = [&sum](const wire::Tag& tag) { sum += std::to_integer<unsigned>(tag[0]); };

  const double blake = least_ns([&] { keep(wire::tag_of(key.secret, {datagram})); });
  const double chacha =
      least_ns([&] { keep(wire::counted_tag_of(key.secret, ++counter, {datagram})); });
  const double sign =
      least_ns([&] { made = wire::sign_datagram(datagram, key, ++counter, space); });
  bool good = true;
  const double verify = least_ns([&] {
    const auto signature = wire::signature_of(made);
    good = good && signature && wire::signed_with(key, *signature, made);
  });
  const double parse = least_ns([&] { good = good && wire::parse_packet(made).has_value(); });
  const auto percent = [](double ns) { return ns * 1e-9 * kPackets * kFramesPerSecond * 100; };
  std::printf(
      "datagram of %4zu bytes, ns: keyed BLAKE2b %.0f, ChaCha20-Poly1305 %.0f; "
      "sign (copy, tag, CRC) %.0f, verify %.0f, parse %.0f\n",
      bytes, blake, chacha, sign, verify, parse);
  std::printf("  at %.0f packets x %.0f Hz, percent of a core: sign %.2f, verify %.2f%s\n",
              kPackets, kFramesPerSecond, percent(sign), percent(verify),
              good && sum > 0 ? "" : "  WRONG");
}

}  // namespace
}  // namespace stof

int main() {
  if (!stof::wire::start_crypto()) {
    return EXIT_FAILURE;
  }
  for (const std::size_t bytes : {200U, 1000U, 1232U}) {
    stof::measure(bytes);
  }
  return EXIT_SUCCESS;
}
