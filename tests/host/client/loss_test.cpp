// Frames through a bad network. STOF_LONG=1: 100,000 frames in all, some minutes.
#include <chrono>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/reassembler.h"
#include "host/netem/impairment.h"
#include "tests/host/client/test_pattern.h"
#include "tests/support/long_tests.h"

namespace stof::client {
namespace {

using test::Datagram;
using wire::Coding;
using wire::Stream;

constexpr Duration kPeriod = std::chrono::milliseconds(33);
// 72 packets: more than the 64 that one may be overtaken by, so that two frames in flight suffice.
constexpr test::PatternSizes kSizes{.width = 560, .height = 28};
constexpr std::uint64_t kPixels = 3ULL * 560 * 28;

wire::StreamChoice map_streams(bool parity) {
  wire::StreamChoice choice = test::raw_map();
  choice.parity = parity;
  return choice;
}

struct Weather {
  std::string name;
  netem::ImpairmentOptions link;
  bool parity = false;
  std::uint32_t first = 0xFFFFFFE0;  // frame number
};

struct Outcome {
  std::uint64_t frames = 0;          // sent
  std::uint64_t complete = 0;        // delivered whole
  std::uint64_t delivered = 0;       // whole or not
  std::uint64_t arrived_pixels = 0;  // of depth, width, source, in frames
  std::uint64_t through_pixels = 0;  // in distinct undamaged datagrams
  std::uint64_t wrong = 0;
  Statistics statistics;
  netem::Impairment::Counts link;
};

class Journey {
 public:
  explicit Journey(const Weather& weather) : weather_(weather), link_(weather.link) {}

  Outcome of(std::uint32_t frames) {
    for (std::uint32_t i = 0; i < frames; ++i) {
      const std::uint32_t number = weather_.first + i;
      const test::FrameSpec spec{.number = number, .freshness = number};
      const std::vector<Datagram> packets =
          test::pattern_datagrams(spec, kSizes, map_streams(weather_.parity));
      for (const Datagram& packet : packets) {
        link_.push(packet, now_);
        arrive();
        now_ += kPeriod / static_cast<int>(packets.size());  // without a gap between two frames
      }
      reassembler_.expire(now_);
      take();
    }
    now_ += std::chrono::seconds(1);
    arrive();
    reassembler_.expire(now_ + std::chrono::seconds(1));
    take();
    outcome_.frames = frames;
    outcome_.statistics = reassembler_.statistics();
    outcome_.link = link_.counts();
    return outcome_;
  }

 private:
  void arrive() {
    while (const auto datagram = link_.pop(now_)) {
      note(*datagram);
      reassembler_.push(*datagram, now_);
      take();
    }
  }

  void note(std::span<const std::byte> datagram) {
    const auto packet = wire::parse_packet(datagram);
    if (packet && packet->header.type == wire::PacketType::kTile &&
        seen_.emplace(packet->header.frame.number - weather_.first, packet->header.index).second) {
      outcome_.through_pixels += packet->header.pixel_count;
    }
    if (seen_.size() > 1000) {
      seen_.erase(seen_.begin());  // long past
    }
  }

  void take() {
    while (const std::optional<Frame> frame = reassembler_.take()) {
      const test::Judgement judgement = test::judge(*frame);
      outcome_.wrong += judgement.wrong;
      ++outcome_.delivered;
      outcome_.complete += frame->complete() ? 1U : 0U;
      for (const auto& [image, stream] : {std::pair(frame->depth.empty(), Stream::kDepth),
                                          std::pair(frame->interval_width.empty(), Stream::kWidth),
                                          std::pair(frame->source.empty(), Stream::kSource)}) {
        outcome_.arrived_pixels += image ? 0 : kPixels / 3 - frame->missing_pixels(stream);
      }
    }
  }

  const Weather& weather_;
  netem::Impairment link_;
  Reassembler reassembler_;
  Time now_{};
  Outcome outcome_;
  std::set<std::pair<std::uint32_t, std::uint16_t>> seen_;
};

std::vector<Weather> weathers() {
  std::vector<Weather> all;
  std::uint64_t seed = 1;
  for (const double loss : {0.0001, 0.001, 0.01, 0.05}) {
    const std::string name = std::to_string(100 * loss) + " % lost";
    all.push_back({name, {.loss = loss, .seed = seed++}});
    all.push_back({name + ", 64 reordered", {.loss = loss, .reorder = 64, .seed = seed++}});
    all.push_back({name + ", 64 reordered, 5 % twice",
                   {.loss = loss, .duplicate = 0.05, .reorder = 64, .seed = seed++},
                   false,
                   0xFFE0});
    all.push_back({name + ", in bursts of 5", {.loss = loss, .burst = 5, .seed = seed++}});
  }
  all.push_back({"1 % damaged", {.corrupt = 0.01, .seed = seed++}});
  all.push_back({"jitter", {.loss = 0.001, .jitter = kPeriod / 8, .seed = seed++}});
  return all;
}

// What arrived undamaged is in a frame, but for a tenth of a percent; nothing else ever is.
TEST(Loss, CostsWhatWasLostAndNothingElse) {
  const std::vector<Weather> all = weathers();
  const auto frames =
      test::long_tests() ? static_cast<std::uint32_t>(100'000 / all.size()) : std::uint32_t{25};
  for (const Weather& weather : all) {
    const Outcome outcome = Journey(weather).of(frames);
    SCOPED_TRACE(weather.name);
    EXPECT_EQ(outcome.wrong, 0U);
    EXPECT_LE(outcome.arrived_pixels, outcome.through_pixels);
    const double sent = static_cast<double>(outcome.frames * kPixels);
    const double through = static_cast<double>(outcome.through_pixels) / sent;
    const double arrived = static_cast<double>(outcome.arrived_pixels) / sent;
    EXPECT_GE(arrived, through - 0.001);
    if (test::long_tests() && weather.link.burst == 1) {
      EXPECT_GE(arrived, 1 - weather.link.loss - weather.link.corrupt - 0.001);
    }
    EXPECT_EQ(outcome.statistics.packets(), outcome.link.out);
    EXPECT_EQ(outcome.statistics.bad_field + outcome.statistics.unknown, 0U);
    EXPECT_EQ(outcome.delivered + outcome.statistics.frames_lost, outcome.frames);
    if (test::long_tests()) {
      std::printf("%-40s pixels %.4f %%, frames whole %.2f %%\n", weather.name.c_str(),
                  100 * arrived,
                  100 * static_cast<double>(outcome.complete) / static_cast<double>(frames));
    }
  }
}

TEST(Loss, WithParityNearlyEveryFrameIsWhole) {
  const std::uint32_t frames = test::long_tests() ? 20'000 : 200;
  for (const int reorder : {0, 64}) {
    const Weather weather{"", {.loss = 0.001, .reorder = reorder, .seed = 77}, true};
    const Outcome outcome = Journey(weather).of(frames);
    EXPECT_EQ(outcome.wrong, 0U);
    EXPECT_GE(outcome.complete * 1000, outcome.frames * 995);
    EXPECT_GT(outcome.statistics.recovered, 0U);
    const Weather bare{"", {.loss = 0.001, .reorder = reorder, .seed = 77}, false};
    EXPECT_LT(Journey(bare).of(frames / 4).complete * 1000, outcome.frames / 4 * 985);
    if (test::long_tests()) {
      std::printf("parity, reorder %d: %.3f %% of the frames whole, %llu packets recovered\n",
                  reorder,
                  100 * static_cast<double>(outcome.complete) / static_cast<double>(frames),
                  static_cast<unsigned long long>(outcome.statistics.recovered));
    }
  }
}

// The sender starts again and again; what it sent before straggles in.
TEST(Loss, AThousandSessionsNeverMix) {
  constexpr std::uint32_t kSessions = 1000;
  constexpr test::PatternSizes kSmall{.width = 40, .height = 30};
  test::Random random(5);
  Reassembler reassembler;
  std::vector<Datagram> stragglers;
  std::uint64_t frames = 0;
  std::set<std::uint32_t> heard;
  const auto push = [&](const Datagram& packet) {
    reassembler.push(packet, Time{});
    while (const std::optional<Frame> frame = reassembler.take()) {
      ++frames;
      heard.insert(frame->origin.session_id);
      ASSERT_EQ(test::judge(*frame, frame->stamp.number + 31 * frame->origin.session_id).wrong, 0U);
    }
  };
  for (std::uint32_t session = 1; session <= kSessions; ++session) {
    std::vector<Datagram> sent;
    for (std::uint32_t number = 1; number <= 3; ++number) {
      const test::FrameSpec spec{
          .number = number, .freshness = number, .origin = {.device_id = 1, .session_id = session}};
      const auto packets = test::pattern_datagrams(spec, kSmall, map_streams(session % 2 == 0),
                                                   number + 31 * session);
      sent.insert(sent.end(), packets.begin(), packets.end());
    }
    // It is switched off anywhere after its first frame, and up to ten of its last packets come
    // after the next start.
    sent.resize(static_cast<std::size_t>(random.between(20, static_cast<int>(sent.size()))));
    reassembler.expect({.device_id = 1, .session_id = session});
    const std::size_t late = static_cast<std::size_t>(random.between(0, 10));
    push(sent.front());
    for (const Datagram& straggler : stragglers) {
      push(straggler);
    }
    stragglers.assign(sent.end() - static_cast<std::ptrdiff_t>(late), sent.end());
    sent.resize(sent.size() - late);
    for (std::size_t i = 1; i < sent.size(); ++i) {
      push(sent[i]);
    }
  }
  const Statistics& statistics = reassembler.statistics();
  EXPECT_EQ(statistics.sessions, kSessions);
  EXPECT_GT(statistics.foreign, kSessions);
  EXPECT_GT(statistics.frames_dropped, 0U);
  EXPECT_EQ(heard.size(), kSessions) << frames;
}

}  // namespace
}  // namespace stof::client
