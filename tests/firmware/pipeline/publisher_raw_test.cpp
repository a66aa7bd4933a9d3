#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "tests/firmware/pipeline/noise_scene.h"

// Raw pictures beside the frames of a publisher.
namespace stof::firmware {
namespace {

using namespace test;

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
        EXPECT_TRUE(
            wire::signed_with(wire::StreamTagger(numbered_stream_key(4)), *signature, one.bytes));
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

}  // namespace
}  // namespace stof::firmware
