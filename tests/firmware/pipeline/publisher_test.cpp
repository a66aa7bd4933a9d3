#include "firmware/pipeline/publisher.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/messages/frame_info.h"
#include "hal/emu/devices/clock.h"
#include "hal/emu/devices/datagram_port.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"
#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;
namespace emu = hal::emu;

constexpr wire::FrameSizes kSizes{.width = 160, .height = 90, .pmd_width = 40, .pmd_height = 30};
constexpr wire::CalibrationPacket kLens{
    .fx = 1 << 22, .fy = 1 << 22, .cx = 1 << 21, .cy = 1 << 21, .max_range = 40'000};
constexpr int kQueue = 1000;  // datagrams, more than a frame has

template <typename T>
class Noise {
 public:
  Noise(int width, int height, std::uint64_t seed, int most)
      : pixels_(static_cast<std::size_t>(width * height)), width_(width), height_(height) {
    test::Random random(seed);
    for (T& pixel : pixels_) {
      pixel = static_cast<T>(random.between(0, most));
    }
  }
  dsp::ImageView<T> view() { return {pixels_.data(), width_, height_}; }

 private:
  std::vector<T> pixels_;
  int width_;
  int height_;
};

class NoOwner final : public hal::SlotOwner {
 public:
  void give_back(int) noexcept override {}
};

// One frame of noise: no codec makes it shorter.
struct Scene {
  explicit Scene(std::uint64_t seed, int w = kSizes.width, int h = kSizes.height)
      : depth(w, h, seed, 65'535),
        width(w, h, seed + 1, 65'535),
        source(w, h, seed + 2, 5),
        cause(w, h, seed + 3, 5),
        left(w, h, seed + 4, 255),
        right(w, h, seed + 5, 255),
        disparity_raw(w, h, seed + 6, 30'000),
        samples{noise(seed + 7), noise(seed + 8), noise(seed + 9), noise(seed + 10)},
        disparity(static_cast<std::size_t>(w * h)) {
    for (int i = 0; i < w * h; ++i) {
      disparity[static_cast<std::size_t>(i)].raw = disparity_raw.view().at(i % w, i / w);
    }
    output.map = {depth.view(), width.view(), source.view(), cause.view()};
    output.stereo.disparity = {disparity.data(), w, h};
    output.left = left.view();
    output.right = right.view();
    pmd.samples = {samples[0].view(), samples[1].view(), samples[2].view(), samples[3].view()};
  }
  Shot shot() {
    return {.edge = emu::Clock::kStart,
            .exposed = {},
            .stereo = hal::BorrowedFrame<hal::StereoFrame>(stereo, owner, 0),
            .pmd = hal::BorrowedFrame<hal::PmdFrame>(pmd, owner, 0),
            .pmd_exposed = hal::Time{}};
  }
  static Noise<std::uint16_t> noise(std::uint64_t seed) {
    return {kSizes.pmd_width, kSizes.pmd_height, seed, 4095};
  }
  wire::FrameImages images() {
    return {.map = output.map,
            .disparity = output.stereo.disparity,
            .pmd = pmd.samples,
            .left = output.left,
            .right = output.right};
  }

  Noise<dsp::QuarterMm> depth, width;
  Noise<dsp::Source> source;
  Noise<dsp::Cause> cause;
  Noise<std::uint8_t> left, right;
  Noise<std::int16_t> disparity_raw;
  std::array<Noise<std::uint16_t>, 4> samples;
  std::vector<dsp::Disparity> disparity;
  hal::StereoFrame stereo;
  hal::PmdFrame pmd;
  NoOwner owner;
  Output output;
};

wire::StreamChoice everything(wire::Coding coding, bool parity) {
  wire::StreamChoice choice{.parity = parity, .cloud_step = 2};
  choice.coding.fill(coding);
  return choice;
}

using Datagrams = std::vector<std::vector<std::byte>>;

// Without what is no part of the frame.
Datagrams frame_of(emu::DatagramPort& port) {
  Datagrams frame;
  while (const auto sent = port.take_sent()) {
    const auto packet = wire::parse_packet(sent->bytes);
    EXPECT_TRUE(packet);
    if (packet && packet->header.type != wire::PacketType::kCalibration) {
      frame.emplace_back(sent->bytes.begin(), sent->bytes.end());
    }
  }
  return frame;
}

// At ports 1 to `count`.
ReceiverList receivers_at_ports(std::size_t count) {
  ReceiverList list{.count = count};
  for (std::size_t i = 0; i < count; ++i) {
    list.peers[i].port = static_cast<std::uint16_t>(i + 1);
  }
  return list;
}

// The publisher with the memory of the appliance, which holds the usual streams.
struct Sender {
  explicit Sender(const wire::StreamChoice& choice, int queue = kQueue,
                  const emu::FaultPlan& faults = {}, hal::DatagramPort* other = nullptr)
      : port(queue, faults), in_memory([&](dsp::Arena& arena) {
          return Publisher({.origin = {.device_id = 7, .session_id = 9}, .calibration = kLens},
                           kSizes, clock, other != nullptr ? *other : port, nullptr, events, arena);
        }) {
    publisher.set_params({.choice = choice, .period = 33ms});
    const hal::Peer receiver{.address = {}, .port = 1};
    publisher.set_receivers({.peers = {receiver}, .count = 1});
  }
  Status publish(Scene& scene) {
    return publisher.publish(scene.shot(), scene.output, clock.now() + 20ms);
  }

  emu::Clock clock;
  emu::DatagramPort port;
  Events events;
  stof::test::GuardedPart<Publisher> in_memory;
  Publisher& publisher = *in_memory;
};

// That these are the frame's datagrams as a coder with memory for all of them makes them: but for
// the frame info, which tells times, and parity over it.
void expect_frame(const Datagrams& sent, Scene& scene, const wire::StreamChoice& choice) {
  stof::test::CoderInMemory coder({.device_id = 7, .session_id = 9}, kSizes, kLens);
  const wire::Datagrams whole = coder->code({}, {}, scene.images(), choice).value();
  ASSERT_EQ(sent.size(), whole.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const wire::PacketView is = wire::parse_packet(sent[i]).value();
    const wire::PacketView should = wire::parse_packet(whole[i]).value();
    ASSERT_EQ(is.header.type, should.header.type);
    ASSERT_EQ(is.header.index, should.header.index);
    ASSERT_EQ(is.header.count, should.header.count);
    if (is.header.type == wire::PacketType::kFrameInfo) {
      const auto info = wire::decode_frame_info(is.payload).value();
      const auto told = wire::decode_frame_info(should.payload).value();
      ASSERT_EQ(info.tiles, told.tiles);
      ASSERT_EQ(info.parity_groups, told.parity_groups);
    } else if (is.header.type == wire::PacketType::kTile) {
      ASSERT_EQ(is.header.stream, should.header.stream);
      ASSERT_EQ(is.header.codec, should.header.codec);
      ASSERT_EQ(is.header.flags, should.header.flags);
      ASSERT_EQ(is.header.first_row, should.header.first_row);
      ASSERT_EQ(is.header.first_column, should.header.first_column);
      ASSERT_EQ(is.header.pixel_count, should.header.pixel_count);
      ASSERT_TRUE(std::ranges::equal(is.payload, should.payload)) << i;
    }
  }
}

TEST(Publisher, AFrameLargerThanItsMemoryIsSentWhole) {
  for (const wire::Coding coding :
       {wire::Coding::kRaw, wire::Coding::kRvl, wire::Coding::kQuantised}) {
    for (const bool parity : {false, true}) {
      const wire::StreamChoice choice = everything(coding, parity);
      Sender sender(choice);
      for (std::uint64_t frame = 0; frame < 3; ++frame) {
        Scene scene(100 * frame);
        const hal::Time begin = sender.clock.now();
        ASSERT_EQ(sender.publish(scene), Status::kOk);
        EXPECT_LE(sender.clock.now(), begin + 20ms);
        const Datagrams sent = frame_of(sender.port);
        EXPECT_GT(sent.size(), 2 * wire::FrameCoder::usual_packets(kSizes));
        expect_frame(sent, scene, choice);
      }
      EXPECT_EQ(sender.events.counters.packets_dropped, 0U);
    }
  }
}

TEST(Publisher, EveryReceiverGetsALargeFrameWhole) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, true);
  Sender sender(choice);
  const ReceiverList receivers = receivers_at_ports(2);
  sender.publisher.set_receivers(receivers);
  Scene scene(5);
  ASSERT_EQ(sender.publish(scene), Status::kOk);
  std::array<Datagrams, 2> got;
  while (const auto sent = sender.port.take_sent()) {
    if (wire::parse_packet(sent->bytes)->header.type != wire::PacketType::kCalibration) {
      got.at(sent->to.port - 1U).emplace_back(sent->bytes.begin(), sent->bytes.end());
    }
  }
  expect_frame(got[0], scene, choice);
  EXPECT_TRUE(got[0] == got[1]);
}

// What does not leave is counted, and what leaves says that it is not all.
TEST(Publisher, WhatAFullLinkDropsOfALargeFrameIsCounted) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, true);
  Scene scene(1);
  Sender all(choice);
  ASSERT_EQ(all.publish(scene), Status::kOk);
  const Datagrams whole = frame_of(all.port);
  for (const int queue : {1, 2, 30, 100}) {
    Sender sender(choice, queue);
    EXPECT_EQ(sender.publish(scene), Status::kWouldBlock);
    const Counters& counters = sender.events.counters;
    EXPECT_EQ(counters.packets_sent, static_cast<std::size_t>(queue));  // with the calibration
    EXPECT_EQ(counters.packets_sent + counters.packets_dropped, whole.size() + 1);
    const Datagrams sent = frame_of(sender.port);
    ASSERT_EQ(sent.size(), static_cast<std::size_t>(queue) - 1);
    for (std::size_t i = 0; i < sent.size(); ++i) {
      EXPECT_TRUE(i == 0 || sent[i] == whole[i]) << i;
      EXPECT_EQ(wire::parse_packet(sent[i])->header.count,
                wire::parse_packet(whole[i])->header.count);
    }
  }
}

TEST(Publisher, AfterALargeFrameThatWasCutOffTheNextIsWhole) {
  const wire::StreamChoice choice = everything(wire::Coding::kRvl, true);
  for (const emu::FaultKind kind : emu::kAllFaultKinds) {
    Sender sender(choice, kQueue, {{.kind = kind, .call = 60, .every = 0, .duration = 1ms}});
    Scene first(3);
    static_cast<void>(sender.publish(first));
    EXPECT_EQ(sender.events.counters.packets_dropped, kind == emu::FaultKind::kVanish ? 1U : 0U);
    while (sender.port.take_sent()) {
    }
    sender.clock.wait_until(sender.clock.now() + 33ms);
    Scene second(4);
    ASSERT_EQ(sender.publish(second), Status::kOk);
    expect_frame(frame_of(sender.port), second, choice);
  }
}

// Goes away after some datagrams.
class LostPort final : public hal::DatagramPort {
 public:
  explicit LostPort(std::size_t datagrams) : left_(datagrams) {}
  Status send(const hal::Peer&, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override {
    sent = std::min(left_, datagrams.size());
    left_ -= sent;
    return sent < datagrams.size() ? Status::kDeviceLost : Status::kOk;
  }
  Result<hal::Received> receive(std::span<std::byte>, hal::Duration) noexcept override {
    return fail(Status::kTimeout);
  }
  std::uint64_t overruns() const noexcept override { return 0; }
  bool take_unreachable(hal::Peer&) noexcept override { return false; }
  std::uint16_t port() const noexcept override { return 1; }

 private:
  std::size_t left_;
};

TEST(Publisher, SendsToAsManyAsMaySubscribe) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, false);
  Scene scene(1);
  Sender one(choice);
  ASSERT_EQ(one.publish(scene), Status::kOk);
  Sender all(choice, kMostSubscribers * kQueue);
  all.publisher.set_receivers(receivers_at_ports(kMostSubscribers));
  ASSERT_EQ(all.publish(scene), Status::kOk);
  EXPECT_EQ(all.events.counters.packets_sent, kMostSubscribers * one.events.counters.packets_sent);
}

TEST(Publisher, WhatALostDeviceLeavesOfALargeFrameIsCounted) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, true);
  Scene scene(1);
  Sender all(choice);
  ASSERT_EQ(all.publish(scene), Status::kOk);
  const std::uint64_t whole = all.events.counters.packets_sent;
  const ReceiverList receivers = receivers_at_ports(3);
  for (const std::size_t datagrams : {0U, 1U, 9U, 90U}) {
    LostPort port(datagrams);
    Sender sender(choice, 1, {}, &port);
    sender.publisher.set_receivers(receivers);
    EXPECT_EQ(sender.publish(scene), Status::kDeviceLost);
    EXPECT_EQ(sender.events.counters.packets_sent, datagrams);
    EXPECT_EQ(sender.events.counters.packets_dropped, receivers.count * whole - datagrams);
  }
}

wire::StreamKey numbered_stream_key(std::uint32_t number) {
  wire::StreamKey key{.number = number};
  key.secret.fill(static_cast<std::byte>(number));
  return key;
}

// What each of three receivers gets: its datagrams as they were before they were signed, the
// counters in order.
struct Signed {
  Datagrams plain;
  std::vector<std::uint64_t> counters;
};
std::array<Signed, 3> got_by(emu::DatagramPort& port, const ReceiverList& receivers) {
  std::array<Signed, 3> got;
  while (const auto sent = port.take_sent()) {
    const std::size_t receiver = sent->to.port - 1U;
    const auto packet = wire::parse_packet(sent->bytes);
    EXPECT_TRUE(packet);
    EXPECT_LE(sent->bytes.size(), wire::kMaxDatagram);
    const auto signature = wire::signature_of(sent->bytes);
    const wire::StreamKey& key = receivers.keys.at(receiver);
    EXPECT_EQ(signature.has_value(), key.number != 0);
    if (signature) {
      EXPECT_EQ(signature->number, key.number);
      EXPECT_TRUE(wire::signed_with(key, *signature, sent->bytes));
      got.at(receiver).counters.push_back(signature->counter);
    }
    wire::DatagramBuffer space{};
    std::ranges::copy(packet->payload, wire::payload_space(space).begin());
    const auto plain = wire::seal_packet(packet->header, packet->payload.size(), space);
    got.at(receiver).plain.emplace_back(plain.begin(), plain.end());
  }
  return got;
}

std::vector<std::uint64_t> numbers(std::uint64_t first, std::size_t count) {
  std::vector<std::uint64_t> all(count);
  std::ranges::generate(all, [&] { return first++; });
  return all;
}

TEST(Publisher, SignsForEachWhoAskedAndCountsOn) {
  ASSERT_TRUE(wire::start_crypto());
  for (const int pace : {0, 60}) {
    Sender sender(everything(wire::Coding::kQuantised, true), 4 * kQueue);
    sender.publisher.set_params({.choice = everything(wire::Coding::kQuantised, true),
                                 .pace_percent = pace,
                                 .period = 33ms});
    ReceiverList receivers = receivers_at_ports(3);
    receivers.keys[0] = numbered_stream_key(1);
    receivers.keys[2] = numbered_stream_key(2);
    sender.publisher.set_receivers(receivers);
    Scene scene(1);
    ASSERT_EQ(sender.publish(scene), Status::kOk);
    sender.publisher.report({});
    const auto first = got_by(sender.port, receivers);
    EXPECT_GT(first[1].plain.size(), 100U);
    EXPECT_TRUE(first[0].plain == first[1].plain && first[2].plain == first[1].plain);
    EXPECT_EQ(first[0].counters, numbers(1, first[1].plain.size()));
    EXPECT_EQ(first[2].counters, first[0].counters);

    // The first one leaves: the last one is at another place of the list, and goes on.
    receivers.peers[0] = receivers.peers[2];
    receivers.keys[0] = receivers.keys[2];
    receivers.count = 1;
    sender.publisher.set_receivers(receivers);
    ASSERT_EQ(sender.publish(scene), Status::kOk);
    ReceiverList at_third = receivers_at_ports(3);
    at_third.keys[2] = numbered_stream_key(2);
    const auto second = got_by(sender.port, at_third);
    EXPECT_EQ(second[2].counters, numbers(first[2].counters.size() + 1, second[2].plain.size()));

    // Another key begins anew.
    receivers.keys[0] = at_third.keys[2] = numbered_stream_key(3);
    sender.publisher.set_receivers(receivers);
    ASSERT_EQ(sender.publish(scene), Status::kOk);
    const auto third = got_by(sender.port, at_third);
    EXPECT_EQ(third[2].counters, numbers(1, third[2].plain.size()));
  }
}

TEST(Publisher, WhatALostDeviceLeavesOfASignedFrameIsCounted) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, true);
  Scene scene(1);
  Sender all(choice);
  ASSERT_EQ(all.publish(scene), Status::kOk);
  const std::uint64_t whole = all.events.counters.packets_sent;
  ReceiverList receivers = receivers_at_ports(3);
  receivers.keys[1] = numbered_stream_key(1);
  for (const std::size_t datagrams : {0U, 1U, 9U, 90U}) {
    LostPort port(datagrams);
    Sender sender(choice, 1, {}, &port);
    sender.publisher.set_receivers(receivers);
    EXPECT_EQ(sender.publish(scene), Status::kDeviceLost);
    EXPECT_EQ(sender.events.counters.packets_dropped, receivers.count * whole - datagrams);
  }
}

// Tells by which queue what left when. Those of raw pictures take so many datagrams.
class TimedPort final : public hal::DatagramPort {
 public:
  struct Sent {
    hal::Time at;
    std::size_t stream = 0;
    std::uint16_t to = 0;
    std::vector<std::byte> bytes;

    wire::PacketType type() const { return wire::parse_packet(bytes)->header.type; }
    bool raw() const {
      return type() == wire::PacketType::kRawInfo || type() == wire::PacketType::kRawTile;
    }
  };
  explicit TimedPort(emu::Clock& clock) : clock_(clock) {}
  Status send(const hal::Peer& to, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override {
    return stream(kStreams, to, datagrams, sent);
  }
  Status stream(std::size_t which, const hal::Peer& to,
                std::span<const std::span<const std::byte>> datagrams,
                std::size_t& sent) noexcept override {
    for (sent = 0; sent < datagrams.size(); ++sent) {
      if (which == kShallowStream && raw_room-- <= 0) {
        return Status::kWouldBlock;
      }
      all.push_back({.at = clock_.now(),
                     .stream = which,
                     .to = to.port,
                     .bytes = {datagrams[sent].begin(), datagrams[sent].end()}});
    }
    return Status::kOk;
  }
  Result<hal::Received> receive(std::span<std::byte>, hal::Duration) noexcept override {
    return fail(Status::kTimeout);
  }
  std::uint64_t overruns() const noexcept override { return 0; }
  bool take_unreachable(hal::Peer&) noexcept override { return false; }
  std::uint16_t port() const noexcept override { return 1; }

  int raw_room = 1 << 20;
  std::vector<Sent> all;

 private:
  emu::Clock& clock_;
};

// Three frames, with raw pictures for one of two receivers or without.
struct RawRun {
  explicit RawRun(const wire::RawRequest& raw, int room = 1 << 20, bool with_key = false) {
    std::vector<std::unique_ptr<Scene>> scenes;  // they are lent until their pictures have left
    emu::Clock clock;
    TimedPort port(clock);
    port.raw_room = room;
    ReceiverList receivers = receivers_at_ports(2);
    if (raw.pictures != 0) {
      receivers.raw_receiver = 1;
      receivers.raw = raw;
    }
    receivers.keys[1] = numbered_stream_key(with_key ? 4 : 0);
    stof::test::GuardedPart<Publisher> own([&](dsp::Arena& arena) {
      return Publisher({.origin = {.device_id = 7, .session_id = 9}, .calibration = kLens}, kSizes,
                       clock, port, nullptr, events, arena);
    });
    own->set_params({.choice = everything(wire::Coding::kQuantised, true), .period = 33ms});
    own->set_receivers(receivers);
    for (int frame = 0; frame < 3; ++frame) {
      Scene& scene = *scenes.emplace_back(std::make_unique<Scene>(50));
      scene.stereo.left = scene.left.view();
      scene.stereo.right = scene.right.view();
      Shot shot = scene.shot();
      const hal::Time edge = clock.now();
      shot.edge = edge;
      statuses.push_back(own->publish(shot, scene.output, edge + 20ms));
      own->offer_raw(shot);
      own->wait_until(edge + 33ms);
    }
    for (TimedPort::Sent& sent : port.all) {
      (sent.raw() ? pictures : others).push_back(std::move(sent));
    }
  }

  Events events;
  std::vector<Status> statuses;
  std::vector<TimedPort::Sent> pictures;
  std::vector<TimedPort::Sent> others;
};

// But for the frame info, which tells times and what was sent, and parity over it.
void expect_same_frames(const RawRun& run, const RawRun& usual) {
  ASSERT_EQ(run.others.size(), usual.others.size());
  for (std::size_t i = 0; i < run.others.size(); ++i) {
    EXPECT_EQ(run.others[i].at, usual.others[i].at) << i;
    EXPECT_EQ(run.others[i].to, usual.others[i].to);
    ASSERT_EQ(run.others[i].type(), usual.others[i].type());
    if (run.others[i].type() == wire::PacketType::kTile) {
      EXPECT_TRUE(run.others[i].bytes == usual.others[i].bytes);
    }
  }
}

TEST(Publisher, RawPicturesGoToWhoAskedAloneAndMoveNoFrame) {
  const RawRun usual({});
  EXPECT_TRUE(usual.pictures.empty());
  const RawRun run({.pictures = wire::kRawPictures});
  ASSERT_FALSE(run.pictures.empty());
  std::size_t whole = 0;
  for (const TimedPort::Sent& sent : run.pictures) {
    EXPECT_EQ(sent.to, 2);
    EXPECT_EQ(sent.stream, hal::DatagramPort::kShallowStream);
    const wire::Header header = wire::parse_packet(sent.bytes)->header;
    whole += header.index + 1U == header.count ? 1U : 0U;
  }
  EXPECT_GE(whole, 1U);
  expect_same_frames(run, usual);
  EXPECT_EQ(run.events.counters.packets_sent,
            usual.events.counters.packets_sent + run.pictures.size());
}

TEST(Publisher, AQueueThatTakesNoRawPicturesDropsNothingOfAFrame) {
  const RawRun usual({});
  for (const int room : {0, 1, 13}) {
    const RawRun run({.pictures = wire::kRawPictures}, room);
    EXPECT_EQ(run.pictures.size(), static_cast<std::size_t>(room));
    EXPECT_EQ(run.events.counters.packets_dropped, 0U);
    EXPECT_EQ(run.statuses, std::vector<Status>(3, Status::kOk));
    expect_same_frames(run, usual);
  }
}

TEST(Publisher, RawPicturesAreSignedForWhoAskedForThat) {
  ASSERT_TRUE(wire::start_crypto());
  const RawRun run({.pictures = wire::kRawPictures}, 1 << 20, true);
  ASSERT_FALSE(run.pictures.empty());
  std::vector<std::uint64_t> counters;
  for (const auto* sent : {&run.pictures, &run.others}) {
    for (const TimedPort::Sent& one : *sent) {
      const auto signature = wire::signature_of(one.bytes);
      ASSERT_EQ(signature.has_value(), one.to == 2);
      if (signature) {
        EXPECT_TRUE(wire::signed_with(numbered_stream_key(4), *signature, one.bytes));
        EXPECT_LE(one.bytes.size(), wire::kMaxDatagram);
        counters.push_back(signature->counter);
      }
    }
  }
  std::ranges::sort(counters);
  EXPECT_TRUE(std::ranges::adjacent_find(counters) == counters.end()) << "a counter comes once";
}

TEST(Publisher, RawPicturesBeginAnewForAnotherReceiver) {
  Sender sender(everything(wire::Coding::kQuantised, false));
  Scene scene(1);
  scene.stereo.left = scene.left.view();
  ReceiverList receivers = receivers_at_ports(2);
  receivers.raw = {.pictures = wire::kRawLeft};
  for (const std::size_t receiver : {0U, 1U}) {
    receivers.raw_receiver = receiver;
    sender.publisher.set_receivers(receivers);
    sender.publisher.set_receivers(receivers);  // the same again changes nothing
    for (std::uint32_t number = 1; number <= 2; ++number) {
      Shot shot = scene.shot();
      ASSERT_EQ(sender.publisher.publish(shot, scene.output, sender.clock.now()), Status::kOk);
      sender.publisher.offer_raw(shot);
      sender.publisher.wait_until(sender.clock.now() + 30ms);
      std::size_t infos = 0;
      while (const auto sent = sender.port.take_sent()) {
        const auto packet = wire::parse_packet(sent->bytes);
        if (packet->header.type == wire::PacketType::kRawInfo) {
          EXPECT_EQ(wire::decode_raw_info(packet->payload)->number, number);
          EXPECT_EQ(sent->to.port, receiver + 1);
          ++infos;
        }
      }
      EXPECT_EQ(infos, 1U);
    }
  }
}

// Nothing of it is sent, and its number is missing.
TEST(Publisher, PicturesLargerThanSaidAreRefusedWhole) {
  const wire::StreamChoice choice = everything(wire::Coding::kQuantised, true);
  Sender sender(choice);
  Scene larger(1, kSizes.width + 1);
  EXPECT_EQ(sender.publish(larger), Status::kTooLarge);
  EXPECT_TRUE(frame_of(sender.port).empty());
  Scene usual(2);
  ASSERT_EQ(sender.publish(usual), Status::kOk);
  const Datagrams sent = frame_of(sender.port);
  expect_frame(sent, usual, choice);
  EXPECT_EQ(wire::parse_packet(sent[0])->header.frame.number, 1U);
}

}  // namespace
}  // namespace stof::firmware
