#include <algorithm>
#include <atomic>
#include <map>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/frame/raw_packets.h"
#include "tests/firmware/rig.h"

// Raw pictures beside the frames of the loop: they keep the cameras' slots for a while.
namespace stof::firmware::test {
namespace {

constexpr hal::Peer kReceiver{.address = {}, .port = 1};

void ask(Rig& rig, const wire::RawRequest& raw) {
  rig.publisher.set_receivers({.peers = {kReceiver},
                               .count = 1,
                               .raw_receiver = raw.pictures == 0 ? kMostSubscribers : 0,
                               .raw = raw});
}

// The packets of raw pictures that came, by their exposure's id; and the others' bytes.
struct Beside {
  std::map<std::uint32_t, std::vector<std::vector<std::byte>>> exposures;
  std::vector<std::byte> others;

  void drain(emu::DatagramPort& port) {
    while (const auto sent = port.take_sent()) {
      const auto packet = wire::parse_packet(sent->bytes);
      ASSERT_TRUE(packet);
      const wire::Header& header = packet->header;
      if (header.type == wire::PacketType::kRawInfo || header.type == wire::PacketType::kRawTile) {
        exposures[header.frame.freshness].emplace_back(sent->bytes.begin(), sent->bytes.end());
      } else if (header.type != wire::PacketType::kHealth) {  // which counts packets
        others.insert(others.end(), sent->bytes.begin(), sent->bytes.end());
      }
    }
  }
};

void run(Rig& rig, Beside& beside, int steps, emu::DatagramPort* port = nullptr) {
  for (int i = 0; i < steps; ++i) {
    static_cast<void>(rig.loop.step());
    beside.drain(port != nullptr ? *port : rig.port);
  }
}

// Takes raw pictures or does not.
class SlowPort final : public hal::DatagramPort {
 public:
  Status send(const hal::Peer& to, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override {
    return link.send(to, datagrams, sent);
  }
  Status stream(std::size_t which, const hal::Peer& to,
                std::span<const std::span<const std::byte>> datagrams,
                std::size_t& sent) noexcept override {
    sent = 0;
    return which == kShallowStream && full ? Status::kWouldBlock : send(to, datagrams, sent);
  }
  Result<hal::Received> receive(std::span<std::byte>, hal::Duration) noexcept override {
    return fail(Status::kTimeout);
  }
  std::uint64_t overruns() const noexcept override { return 0; }
  bool take_unreachable(hal::Peer&) noexcept override { return false; }
  std::uint16_t port() const noexcept override { return 1; }

  emu::DatagramPort link{1000};
  bool full = true;
};

constexpr int kSteps = 60;
constexpr wire::RawRequest kAll{.pictures = wire::kRawPictures};

// Of the raw info of each exposure.
std::vector<int> states(const Beside& beside) {
  std::vector<int> all;
  for (const auto& [id, packets] : beside.exposures) {
    for (const std::vector<std::byte>& bytes : packets) {
      const auto packet = wire::parse_packet(bytes);
      if (packet && packet->header.type == wire::PacketType::kRawInfo) {
        all.push_back(wire::decode_raw_info(packet->payload).value_or(wire::RawInfo{}).state);
      }
    }
  }
  return all;
}

TEST(LoopRaw, TellsWhereThePipelineBeganAnewAndWhereNothingOfBeforeCounts) {
  Rig rig{RigOptions{}};
  Beside beside;
  ask(rig, kAll);
  run(rig, beside, 10);
  rig.loop.note_begun_anew();
  run(rig, beside, 10);
  const std::vector<int> all = states(beside);
  ASSERT_GE(all.size(), 15U);
  EXPECT_EQ(all.front(), wire::kRawBegunAnew | wire::kRawForgotPast) << "the first of all";
  EXPECT_EQ(std::ranges::count(all, wire::kRawBegunAnew | wire::kRawForgotPast), 2);
  EXPECT_EQ(std::ranges::count(all, 0), static_cast<int>(all.size()) - 2);
}

TEST(LoopRaw, NoFrameIsAnotherOrLaterForThem) {
  for (const int pmd_every : {1, 2}) {
    RigOptions options;
    options.timing.pmd_every = pmd_every;
    Rig usual(options);
    Beside plain;
    ask(usual, {});
    run(usual, plain, kSteps);
    EXPECT_TRUE(plain.exposures.empty());
    for (const std::uint16_t every : {std::uint16_t{1}, std::uint16_t{3}, std::uint16_t{100}}) {
      Rig rig(options);
      Beside beside;
      ask(rig, {.pictures = wire::kRawPictures, .every = every});
      run(rig, beside, kSteps);
      EXPECT_TRUE(beside.others == plain.others) << "each packet, its latency and its counts";
      EXPECT_EQ(rig.events.counters.published, usual.events.counters.published);
      EXPECT_EQ(rig.log.edges, usual.log.edges);
      EXPECT_EQ(rig.events.counters.stereo_dropped, usual.events.counters.stereo_dropped);
      EXPECT_FALSE(beside.exposures.empty());
    }
  }
}

TEST(LoopRaw, ExposuresComeWholeWithTheStampsOfTheirEdge) {
  Rig rig;
  Beside beside;
  ask(rig, kAll);
  run(rig, beside, kSteps);
  std::size_t whole = 0;
  std::uint32_t number = 0;
  for (const auto& [freshness, packets] : beside.exposures) {
    const wire::PacketView first = wire::parse_packet(packets.front()).value();
    ASSERT_EQ(first.header.type, wire::PacketType::kRawInfo);
    const wire::RawInfo info = wire::decode_raw_info(first.payload).value();
    EXPECT_EQ(info.number, ++number);
    // Once two frames leave in a period, where they begin to go out in that of their own edge.
    EXPECT_LE(info.dropped, 1U);
    EXPECT_EQ(info.pictures, wire::kRawPictures);
    EXPECT_EQ(info.camera_width, kWidth);
    EXPECT_EQ(info.pmd_height, kPmdHeight);
    const hal::Time edge{hal::Duration(info.edge_ns)};
    ASSERT_TRUE(rig.log.find(edge)) << "an edge of the trigger";
    const hal::Time next = edge + timing().period;
    for (const wire::Window& eye : info.pair_exposures) {
      EXPECT_GE(hal::Time{hal::Duration(eye.begin_ns)}, edge);
      EXPECT_LT(hal::Time{hal::Duration(eye.end_ns)}, next);
    }
    for (const wire::Window& sample : info.pmd_exposures) {
      EXPECT_GE(hal::Time{hal::Duration(sample.begin_ns)}, edge);
      EXPECT_LT(hal::Time{hal::Duration(sample.end_ns)}, next);
    }
    whole += packets.size() == first.header.count ? 1U : 0U;
  }
  EXPECT_GE(whole, rig.events.counters.published - 2);
}

// Nothing of its slots is read once it is opened again.
TEST(LoopRaw, ACameraThatIsLostGetsItsSlotsBackAndIsOpenedAtOnce) {
  constexpr std::uint32_t kLost = 20;
  for (emu::FaultPlan Faults::* const device : {&Faults::stereo, &Faults::pmd}) {
    DeviceLending lending(true);
    std::atomic<int> opened = 0;
    std::thread opener([&] {
      while (const auto lent = lending.wait_for_lent()) {
        ++opened;
        lending.give_back(*lent);
      }
    });
    SlowPort port;
    RigOptions options{.port = &port, .lending = &lending};
    options.faults.*device = {emu::Fault{.kind = emu::FaultKind::kVanish, .call = kLost}};
    Rig rig(options);
    Beside beside;
    run(rig, beside, kLost - 3, &port.link);
    ask(rig, {.pictures = wire::kRawPictures, .every = 1000});
    int steps = 0;
    while (opened == 0 && steps < 100) {
      run(rig, beside, 1, &port.link);
      ++steps;
    }
    EXPECT_LE(steps, 5);
    port.full = false;
    run(rig, beside, 2, &port.link);
    EXPECT_TRUE(beside.exposures.empty()) << "of slots that the camera has back";
    ask(rig, kAll);
    run(rig, beside, kSteps, &port.link);
    EXPECT_GT(beside.exposures.size(), std::size_t{kSteps} / 2) << "they go on";
    lending.end();
    opener.join();
  }
}

}  // namespace
}  // namespace stof::firmware::test
