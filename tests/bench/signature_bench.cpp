// stof_signature_bench: what the signatures of a stream take, of one datagram and of a frame.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <thread>
#include <vector>

#include "firmware/wire/keys/signed_stream.h"
#include "host/client/reassembler.h"
#include "host/client/session/stream_verifier.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"
#include "tests/firmware/wire/frame/corridor_frame.h"

namespace stof {
namespace {

constexpr std::uint32_t kSession = 1;

// The least of many turns counts: the machine has more to do.
constexpr int kTurns = 400;
constexpr int kInTurn = 200;
constexpr double kFramesPerSecond = 30;

using Frame = std::vector<std::vector<std::byte>>;

template <typename Work>
double ms_of(const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begin;
  return taken.count();
}

// ns of one.
template <typename Work>
double least_ns(const Work& work) {
  double least = std::numeric_limits<double>::max();
  for (int turn = 0; turn < kTurns; ++turn) {
    least = std::min(least, ms_of([&] {
                              for (int i = 0; i < kInTurn; ++i) {
                                work();
                              }
                            }) * 1e6 /
                                kInTurn);
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
  wire::OneTimeKey once{};
  const double single = least_ns([&] {
    once = wire::one_time_key(key.secret, key.number, ++counter, 0);
    keep(wire::one_time_tag(once, {datagram}));
  });
  std::array<wire::OneTimeKey, wire::StreamTagger::kInBlock> keys{};
  const double block =
      least_ns([&] { wire::derive_one_time_keys(key.secret, key.number, ++counter, keys); }) /
      static_cast<double>(keys.size());
  const double tag = least_ns([&] { keep(wire::one_time_tag(keys[++counter % 2], {datagram})); });
  wire::StreamTagger tagger(key);
  const double sign =
      least_ns([&] { made = wire::sign_datagram(datagram, tagger, ++counter, space); });
  bool good = true;
  const double verify = least_ns([&] {
    const auto signature = wire::signature_of(made);
    good = good && signature && wire::signed_with(tagger, *signature, made);
  });
  // Of somebody who knows the number but not the key, and names a counter of another block each
  // time.
  wire::StreamKey guessed = key;
  guessed.secret[0] ^= std::byte{1};
  wire::StreamTagger forger(guessed);
  std::array<wire::DatagramBuffer, 8> forged_space{};
  std::array<std::span<const std::byte>, forged_space.size()> forged;
  for (std::size_t i = 0; i < forged.size(); ++i) {
    forged[i] = wire::sign_datagram(datagram, forger, 1 + 1'000'003 * i, forged_space[i]);
  }
  client::StreamVerifier verifier;
  verifier.set_key(key, kSession);
  std::size_t next = 0;
  const double refuse = least_ns([&] {
    good = good && verifier.judge(forged[++next % forged.size()], kSession) ==
                       client::StreamVerifier::Verdict::kForged;
  });
  std::printf(
      "datagram of %4zu bytes, ns: keyed BLAKE2b %.0f, Poly1305 %.0f with a key of its own, %.0f "
      "with one of a block, the key among it %.0f; sign (copy, tag, CRC) %.0f, verify %.0f, "
      "refuse a forged one %.0f%s\n",
      bytes, blake, single, tag + block, block, sign, verify + block, refuse,
      good && sum > 0 ? "" : "  WRONG");
}

// Frames of the default streams of the emulated corridor, 640x480, as all receivers get them.
std::vector<Frame> corridor(std::uint32_t frames) {
  test::CorridorFrame images;
  test::CoderInMemory coder({.device_id = 1, .session_id = kSession}, images.sizes(),
                            {.fx = 615 << 16, .fy = 615 << 16, .cx = 320 << 16, .cy = 240 << 16});
  wire::StreamChoice choice;
  for (const wire::Stream stream :
       {wire::Stream::kDepth, wire::Stream::kWidth, wire::Stream::kSource}) {
    choice.of(stream) = wire::Coding::kQuantised;
  }
  std::vector<Frame> all;
  for (std::uint32_t number = 1; number <= frames; ++number) {
    Frame& frame = all.emplace_back();
    const auto coded =
        coder->code({.number = number, .freshness = number}, {}, images.images(), choice);
    for (const std::span<const std::byte> datagram : *coded) {
      frame.emplace_back(datagram.begin(), datagram.end());
    }
  }
  return all;
}

Frame signed_frame(const Frame& frame, const wire::StreamKey& key, std::uint64_t& counter) {
  Frame made;
  wire::DatagramBuffer space{};
  wire::StreamTagger tagger(key);
  for (const auto& datagram : frame) {
    const auto one = wire::sign_datagram(datagram, tagger, ++counter, space);
    made.emplace_back(one.begin(), one.end());
  }
  return made;
}

// What a client takes for one of the frames, the least of all.
double received_ms(const std::vector<Frame>& frames, const wire::StreamKey* key) {
  client::StreamVerifier verifier;
  if (key != nullptr) {
    verifier.set_key(*key, kSession);
  }
  client::Reassembler reassembler({.verifier = key != nullptr ? &verifier : nullptr});
  double least = std::numeric_limits<double>::max();
  for (const Frame& frame : frames) {
    bool whole = false;
    const double ms = ms_of([&] {
      for (const auto& datagram : frame) {
        reassembler.push(datagram, client::Time{});
      }
      whole = reassembler.take().has_value();
    });
    least = whole ? std::min(least, ms) : least;
  }
  return least;
}

// Sender and client, with signatures and without, in turns.
void measure_frame() {
  constexpr std::uint32_t kFrames = 20;
  constexpr int kRounds = 40;
  wire::StreamKey key{.number = 1};
  wire::fill_random(key.secret);
  const std::vector<Frame> plain = corridor(kFrames);
  std::vector<Frame> made;
  std::uint64_t counter = 0;
  for (const Frame& frame : plain) {
    made.push_back(signed_frame(frame, key, counter));
  }
  std::array<wire::DatagramBuffer, 8> space{};
  wire::StreamTagger tagger(key);
  double sign = std::numeric_limits<double>::max();
  double without = sign;
  double with = sign;
  for (int round = 0; round < kRounds; ++round) {
    for (const Frame& frame : plain) {
      sign = std::min(sign, ms_of([&] {
                        for (std::size_t i = 0; i < frame.size(); ++i) {
                          static_cast<void>(wire::sign_datagram(frame[i], tagger, ++counter,
                                                                space[i % space.size()]));
                        }
                      }));
    }
    without = std::min(without, received_ms(plain, nullptr));
    with = std::min(with, received_ms(made, &key));
  }
  const auto percent = [](double ms) { return ms * 1e-3 * kFramesPerSecond * 100; };
  std::printf(
      "frame of %zu datagrams, at %.0f Hz, percent of a core: the sensor signs in %.3f ms, "
      "%.2f; a client takes %.3f in place of %.3f ms, %.2f more\n",
      plain[0].size(), kFramesPerSecond, sign, percent(sign), with, without,
      percent(with - without));
}

// As frames leave: in bursts, with pauses in which the processor does other things. ns of a
// datagram, of the least disturbed frame of each way.
void measure_paced() {
  constexpr std::size_t kBurst = 8;
  constexpr std::array<std::size_t, 3> kAtOnce{kBurst, 64, 512};
  constexpr int kFrames = 12;
  const Frame frame = corridor(1).front();
  std::vector<wire::DatagramBuffer> space(kAtOnce.back());
  wire::StreamKey key{.number = 1};
  wire::fill_random(key.secret);
  wire::StreamTagger tagger(key);
  std::uint64_t counter = 0;
  std::array<double, kAtOnce.size()> least{};
  least.fill(std::numeric_limits<double>::max());
  for (std::size_t turn = 0; turn < kFrames * kAtOnce.size(); ++turn) {
    const std::size_t way = turn % kAtOnce.size();
    double ms = 0;
    for (std::size_t at = 0; at < frame.size(); at += kBurst) {
      std::this_thread::sleep_for(std::chrono::microseconds(300));
      if (at % kAtOnce[way] == 0) {
        const std::size_t end = std::min(frame.size(), at + kAtOnce[way]);
        ms += ms_of([&] {
          for (std::size_t i = at; i < end; ++i) {
            static_cast<void>(wire::sign_datagram(frame[i], tagger, ++counter, space[i - at]));
          }
        });
      }
    }
    least[way] = std::min(least[way], ms);
  }
  std::printf("in bursts of %zu, ns of a datagram:", kBurst);
  for (std::size_t way = 0; way < kAtOnce.size(); ++way) {
    std::printf(" %.0f signed %zu at once%s", least[way] * 1e6 / static_cast<double>(frame.size()),
                kAtOnce[way], way + 1 < kAtOnce.size() ? "," : "\n");
  }
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
  stof::measure_frame();
  stof::measure_paced();
  return EXIT_SUCCESS;
}
