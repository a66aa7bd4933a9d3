#include "firmware/serial/line/serial_link.h"

#include <array>
#include <chrono>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/messages/announce.h"
#include "firmware/wire/messages/discover.h"
#include "firmware/wire/messages/settings_answer.h"
#include "firmware/wire/messages/settings_request.h"
#include "hal/emu/devices/serial_port.h"
#include "hal/linux/ports/serial_tty.h"
#include "tests/firmware/serial/line.h"
#include "tests/support/pty.h"
#include "tests/support/random.h"

namespace stof::firmware::test {
namespace {

using namespace std::chrono_literals;
using hal::emu::FaultKind;
using hal::emu::FaultPlan;
using settings::SerialMode;
using settings::SerialProfile;
using stof::test::Pty;
using stof::test::Random;
using wire::PacketType;

constexpr wire::Origin kSensor{.device_id = 5, .session_id = 6};

// Answers with the text it got.
class Echo final : public SettingsService {
 public:
  wire::SettingsAnswer serve(const wire::SettingsRequest& request, std::span<const std::byte> text,
                             const Requester& /*by*/, std::span<std::byte> answer_text,
                             std::size_t& answer_bytes) noexcept override {
    std::ranges::copy(text, answer_text.begin());
    answer_bytes = text.size();
    return {.result = wire::SettingsResult::kOk,
            .revision = static_cast<std::uint32_t>(request.operation)};
  }
};

Bytes packet(PacketType type, std::span<const std::byte> payload, std::uint32_t device = 0) {
  wire::DatagramBuffer buffer{};
  std::ranges::copy(payload, wire::payload_space(buffer).begin());
  const auto sealed =
      wire::seal_packet({.type = type, .origin = {.device_id = device}}, payload.size(), buffer);
  return {sealed.begin(), sealed.end()};
}

Bytes on_line(const Bytes& packet) {
  Bytes code(hal::cobs_bound(packet.size()) + 1);
  code.resize(hal::cobs_encode(packet, code) + 1);
  code.back() = std::byte{0};
  return code;
}

Bytes discover(std::uint32_t id, std::uint32_t device = 0) {
  std::array<std::byte, wire::kDiscoverBytes> payload{};
  wire::encode_discover({.request_id = id}, payload);
  return on_line(packet(PacketType::kDiscover, payload, device));
}

Bytes settings_request(std::uint32_t id, std::size_t text_bytes) {
  Bytes payload(wire::kSettingsRequestBytes + text_bytes, std::byte{'x'});
  wire::encode_settings_request({.request_id = id, .operation = wire::SettingsOperation::kSet},
                                std::span(payload).first<wire::kSettingsRequestBytes>());
  return on_line(packet(PacketType::kSettingsRequest, payload));
}

struct Line {
  explicit Line(std::size_t capacity = 8192, const FaultPlan& faults = {})
      : port(capacity, 921'600, faults),
        ring(memory),
        requests(kSensor, &echo),
        link(port, ring, requests) {
    link.set(SerialMode::kStof, 921'600);
  }
  void tick(int times = 1) {
    for (int i = 0; i < times; ++i) {
      now += 20ms;
      link.tick(now);
    }
  }
  void drain() {
    std::array<std::byte, 1024> space{};
    while (const std::size_t count = port.take(space)) {
      receiver.feed(std::span<const std::byte>(space).first(count));
    }
  }
  void put(const Bytes& record) {
    ring.put(record);
    ring.publish();
  }

  hal::emu::SerialPort port;
  std::array<std::byte, 65'536> memory{};
  ByteRing ring;
  Echo echo;
  SerialRequestHandler requests;
  SerialLink link;
  LineReceiver receiver;
  hal::Time now{1h};
};

const Bytes kEvent = packet(PacketType::kEvent, std::array<std::byte, 24>{});

TEST(SerialLink, SendsRecordsInOrder) {
  Line line;
  for (int i = 0; i < 20; ++i) {
    line.put(packet(PacketType::kEvent, Bytes(static_cast<std::size_t>(i))));
  }
  line.tick();
  line.drain();
  ASSERT_EQ(line.receiver.packets.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(line.receiver.packets[i].payload.size(), i);
  }
  EXPECT_EQ(line.link.counters().sent, 20U);
  EXPECT_EQ(line.receiver.damaged, 0U);
}

TEST(SerialLink, BeginsWithAZeroAfterSilence) {
  Line line;
  line.put(kEvent);
  line.tick();
  std::array<std::byte, 1024> space{};
  const std::size_t first = line.port.take(space);
  EXPECT_EQ(space[0], std::byte{0});
  line.put(kEvent);
  line.tick();  // soon afterwards: none
  EXPECT_EQ(line.port.take(space), first - 1);
  line.tick(6);
  line.put(kEvent);
  line.tick();
  EXPECT_EQ(line.port.take(space), first);
}

TEST(SerialLink, WaitsForAFullPort) {
  Line line(16);
  line.put(kEvent);
  for (int i = 0; i < 10; ++i) {
    line.tick();
    line.drain();
  }
  EXPECT_EQ(line.receiver.packets.size(), 1U);
  EXPECT_EQ(line.receiver.damaged, 0U);
}

TEST(SerialLink, AnswersDiscoverAndSettings) {
  Line line;
  wire::Announce announce{.port = 7560};
  std::memcpy(announce.name.data(), "stof", 4);
  line.requests.set_announce(announce, wire::Health::kDegraded);
  line.port.feed(discover(77));
  line.port.feed(settings_request(78, 1000));
  line.port.feed(discover(79, kSensor.device_id));
  line.tick(5);
  line.drain();
  ASSERT_EQ(line.receiver.packets.size(), 3U);
  const LinePacket& first = line.receiver.packets[0];
  EXPECT_EQ(first.header.type, PacketType::kAnnounce);
  EXPECT_EQ(first.header.origin.device_id, kSensor.device_id);
  EXPECT_EQ(first.header.frame.health, wire::Health::kDegraded);
  EXPECT_EQ(wire::decode_announce(first.payload)->request_id, 77U);
  EXPECT_EQ(wire::decode_announce(first.payload)->port, 7560);
  const LinePacket& second = line.receiver.packets[1];
  EXPECT_EQ(second.header.type, PacketType::kSettingsAnswer);
  const auto answer = wire::decode_settings_answer(second.payload);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->request_id, 78U);
  EXPECT_EQ(answer->result, wire::SettingsResult::kOk);
  EXPECT_EQ(answer->revision, 1U);
  EXPECT_EQ(second.payload.size(), wire::kSettingsAnswerBytes + 1000);
  EXPECT_EQ(line.link.counters().refused, 0U);
}

TEST(SerialLink, RefusesAndCountsWhatItDoesNotTake) {
  Line line;
  Bytes damaged = discover(1);
  damaged[20] = damaged[20] == std::byte{2} ? std::byte{3} : std::byte{2};
  line.port.feed(damaged);
  line.port.feed(discover(2, kSensor.device_id + 1));
  line.port.feed(on_line(packet(PacketType::kSubscribe, Bytes(32))));
  line.port.feed(on_line(packet(PacketType::kDiscover, Bytes(10))));
  line.port.feed(on_line(packet(PacketType::kSettingsRequest, Bytes(3))));
  line.port.feed(on_line(Bytes(5, std::byte{1})));
  line.tick(10);
  line.drain();
  EXPECT_TRUE(line.receiver.packets.empty());
  EXPECT_EQ(line.link.counters().refused, 6U);
}

TEST(SerialLink, ServesUnderEveryFaultAtEveryCall) {
  for (const FaultKind kind : hal::emu::kAllFaultKinds) {
    for (std::uint32_t call = 0; call < 12; ++call) {
      Line line(600, {{.kind = kind, .call = call, .calls = 2}});
      for (int i = 0; i < 40; ++i) {
        line.put(packet(PacketType::kEvent, Bytes(static_cast<std::size_t>(i))));
        if (i == 10) {
          line.port.feed(discover(1));
        }
        line.tick(10);
        line.drain();
      }
      // At most those that the fault struck are missing, and each one behind it.
      ASSERT_GE(line.receiver.count(PacketType::kEvent), 34U)
          << static_cast<int>(kind) << " at " << call;
      ASSERT_FALSE(line.link.lost());
      ASSERT_LE(line.receiver.damaged, 4U);
      ASSERT_EQ(line.receiver.packets.back().payload.size(), 39U);
    }
  }
}

TEST(SerialLink, OpensALostPortAgainWithMoreAndMorePatience) {
  Line line(8192, {{.kind = FaultKind::kVanish, .call = 1, .calls = 12}});
  line.put(kEvent);
  line.tick();
  line.put(kEvent);
  line.tick();
  EXPECT_TRUE(line.link.lost());
  std::vector<hal::Duration> waits;
  hal::Time last = line.now;
  std::uint32_t calls = line.port.calls();
  while (line.link.lost()) {
    line.put(kEvent);  // thrown away: it would be old when the line is back
    line.now += 1ms;
    line.link.tick(line.now);
    if (line.port.calls() != calls) {
      calls = line.port.calls();
      waits.push_back(line.now - last);
      last = line.now;
    }
    ASSERT_LT(waits.size(), 20U);
  }
  const std::vector<hal::Duration> first{50ms, 100ms, 200ms, 400ms, 800ms, 1s, 1s};
  ASSERT_GE(waits.size(), first.size());
  EXPECT_TRUE(std::equal(first.begin(), first.end(), waits.begin()));
  line.drain();
  const std::size_t before = line.receiver.packets.size();
  line.put(kEvent);
  line.tick();
  line.drain();
  EXPECT_EQ(line.receiver.packets.size(), before + 1);
  EXPECT_GT(line.link.counters().lost, 1000U);
}

// Half a frame is on the line, and no silence long enough to tell.
TEST(SerialLink, BeginsWithAZeroAfterReopening) {
  Line line(8192, {{.kind = FaultKind::kTear, .call = 0}, {.kind = FaultKind::kVanish, .call = 1}});
  line.put(kEvent);
  line.tick(2);
  ASSERT_TRUE(line.link.lost());
  line.now += 50ms;
  line.link.tick(line.now);
  ASSERT_FALSE(line.link.lost());
  line.put(kEvent);
  line.link.tick(line.now);
  line.drain();
  EXPECT_EQ(line.receiver.packets.size(), 1U);
}

TEST(SerialLink, AnswersAtTheOldSpeedBeforeItChanges) {
  Line line;
  line.port.feed(settings_request(1, 1000));
  line.now += 20ms;
  line.link.tick(line.now);
  line.link.set(SerialMode::kStof, 3'000'000);
  line.tick();
  line.drain();
  EXPECT_EQ(line.receiver.count(PacketType::kSettingsAnswer), 1U);
  EXPECT_EQ(line.port.baud(), 921'600U);
  line.put(kEvent);  // not while the speed changes
  line.tick(6);
  EXPECT_EQ(line.port.baud(), 3'000'000U);
  EXPECT_FALSE(line.link.baud_refused());
  line.put(kEvent);
  line.tick();
  line.drain();
  EXPECT_EQ(line.receiver.count(PacketType::kEvent), 1U);
  line.link.set(SerialMode::kStof, 0);  // what the emulated port refuses
  line.tick(20);
  EXPECT_TRUE(line.link.baud_refused());
  EXPECT_EQ(line.port.baud(), 3'000'000U);
}

TEST(SerialLink, SendsMavlinkAsItIsAndHearsAnAutopilot) {
  Line line;
  line.link.set(SerialMode::kMavlink, 921'600);
  mavlink::Writer writer(1, 196);
  mavlink::Buffer buffer{};
  const auto heartbeat = writer.write(mavlink::Heartbeat{}, buffer);
  line.put({heartbeat.begin(), heartbeat.end()});
  line.tick();
  std::array<std::byte, 64> space{};
  ASSERT_EQ(line.port.take(space), heartbeat.size());
  EXPECT_TRUE(std::equal(heartbeat.begin(), heartbeat.end(), space.begin()));
  // Our own heartbeat is no autopilot's.
  line.port.feed(heartbeat);
  line.tick();
  EXPECT_EQ(line.link.autopilot().system, 0);
}

TEST(SerialLink, IsSilentWhileItIsOff) {
  Line line;
  line.link.set(SerialMode::kOff, 921'600);
  line.put(kEvent);
  line.port.feed(discover(1));
  line.tick(3);
  EXPECT_EQ(line.port.waiting(), 0U);
  EXPECT_EQ(line.link.counters().lost, 1U);
}

TEST(SerialLink, WantsShorterTurnsOnFasterLines) {
  EXPECT_EQ(SerialLink::turn(57'600), 20ms);
  EXPECT_EQ(SerialLink::turn(2'048'000), 10ms);
  EXPECT_GE(SerialLink::turn(12'000'000), 1ms);
}

// The whole way: depth map, sender, ring, link, a pseudo-terminal, a receiver.
TEST(SerialLine, CarriesPicturesOverAPseudoTerminal) {
  Pty pty;
  if (!pty.open() && !pty.has_any_speed()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  ASSERT_FALSE(pty.name().empty());
  auto tty = hal::linux::SerialTty::open({.device = pty.name(), .baud = 3'000'000});
  ASSERT_TRUE(tty) << tty.error();
  SenderBench bench;
  Random random(12);
  random.fill(std::span(bench.depth), 4000, 4003);
  random.fill(std::span(bench.width), 1, 4);
  bench.sender.set({.mode = SerialMode::kStof,
                    .profile = SerialProfile::kMedium,
                    .baud = 3'000'000,
                    .rate_hz = 10,
                    .width = true});
  SerialRequestHandler requests(kSensor, nullptr);
  SerialLink link(*tty, bench.ring, requests);
  link.set(SerialMode::kStof, 3'000'000);
  LineReceiver receiver;
  hal::Time now{1h};
  for (int i = 0; i < 400; ++i, now += 5ms) {
    if (i % 20 == 0) {
      bench.frame(now);
    }
    if (i == 100) {
      const Bytes request = discover(1);
      pty.write({reinterpret_cast<const char*>(request.data()), request.size()});
    }
    link.tick(now);
    receiver.feed(pty.read_some());
  }
  EXPECT_EQ(receiver.damaged, 0U);
  EXPECT_EQ(receiver.whole_frames(), 20U);
  EXPECT_EQ(receiver.frames.size(), 20U);
  EXPECT_EQ(receiver.count(PacketType::kAnnounce), 1U);
  EXPECT_EQ(receiver.frames.at(3).columns, 160);
}

}  // namespace
}  // namespace stof::firmware::test
