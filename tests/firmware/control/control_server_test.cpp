#include "firmware/control/control_server.h"

#include <gtest/gtest.h>

#include "hal/emu/devices/datagram_port.h"
#include "tests/firmware/control/requests.h"

// The control thread's turns, one at a time and without a thread.
namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::ControlServer;
using firmware::CookieSecret;
using firmware::LeaseTable;
using firmware::PeriodicTask;
using firmware::ReceiverList;
using firmware::ReceiverRing;
using firmware::RequestHandler;

constexpr hal::Time kStart{1'000s};

class CountedTask final : public PeriodicTask {
 public:
  void tick(hal::Time now) noexcept override {
    ++ticks;
    last = now;
  }
  int ticks = 0;
  hal::Time last;
};

class ControlServerTest : public testing::Test {
 protected:
  void receive() {
    EXPECT_EQ(control_.receive(hal::Duration::zero(), []() noexcept { return kStart; }),
              Status::kOk);
  }
  // All that was answered.
  std::vector<std::pair<hal::Peer, Bytes>> answers() {
    std::vector<std::pair<hal::Peer, Bytes>> out;
    while (const auto sent = port_.take_sent()) {
      out.emplace_back(sent->to, Bytes(sent->bytes.begin(), sent->bytes.end()));
    }
    return out;
  }
  void join(const hal::Peer& from) {
    port_.inject(subscribe({}), from);
    receive();
    const std::uint64_t cookie = subscribed(answers().at(0).second).value().cookie;
    port_.inject(subscribe({.cookie = cookie}), from);
    receive();
    EXPECT_EQ(subscribed(answers().at(0).second).value().result, wire::SubscribeResult::kOk);
  }

  hal::emu::DatagramPort port_{600};
  LeaseTable subscribers_;
  RequestHandler handler_{{.device_id = 1}, CookieSecret{}, subscribers_, nullptr};
  ReceiverRing ring_;
  CountedTask task_;
  std::array<PeriodicTask*, 1> tasks_{&task_};
  ControlServer control_{{.port = port_,
                          .handler = handler_,
                          .subscribers = subscribers_,
                          .ring = ring_,
                          .tasks = tasks_}};
};

TEST_F(ControlServerTest, AnswersWhoeverAsked) {
  port_.inject(subscribe({.request_id = 1}), peer(1));
  port_.inject(subscribe({.request_id = 2}), peer(2));
  receive();
  const auto all = answers();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].first, peer(1));
  EXPECT_EQ(subscribed(all[1].second).value().request_id, 2U);
}

TEST_F(ControlServerTest, TellsTheLoopWhenTheListChangesAndNotOtherwise) {
  control_.tick(kStart);
  EXPECT_FALSE(ring_.pop());
  join(peer(1));
  join(peer(2));
  control_.tick(kStart);
  const std::optional<ReceiverList> list = ring_.pop();
  ASSERT_TRUE(list);
  EXPECT_EQ(list->count, 2U);
  EXPECT_EQ(list->peers[1], peer(2));
  join(peer(1));  // renews
  control_.tick(kStart + 1s);
  EXPECT_FALSE(ring_.pop());
  control_.tick(kStart + 3s);
  EXPECT_EQ(ring_.pop().value().count, 0U);
}

TEST_F(ControlServerTest, AFullRingGetsTheNewestListLater) {
  for (int i = 0; i < 20; ++i) {  // more changes than the ring_ takes
    join(peer(1));
    control_.tick(kStart);
    subscribers_.unsubscribe(peer(1));
    control_.tick(kStart);
  }
  join(peer(7));
  control_.tick(kStart);
  while (ring_.pop()) {
  }
  control_.tick(kStart);
  const std::optional<ReceiverList> list = ring_.pop();
  ASSERT_TRUE(list);
  EXPECT_EQ(list->all()[0], peer(7));
}

// "Nobody listens there" is an answer that anybody can forge.
TEST_F(ControlServerTest, ARefusalEndsNoLease) {
  join(peer(1));
  join(peer(2));
  port_.refuse(peer(1));
  control_.tick(kStart);
  EXPECT_EQ(ring_.pop().value().count, 2U);
  EXPECT_EQ(subscribers_.count(), 2U);
}

TEST_F(ControlServerTest, AFloodKeepsTheTasksWaitingForOneTurnOnly) {
  for (int i = 0; i < 600; ++i) {
    port_.inject(Bytes(10), peer(1));
  }
  receive();
  EXPECT_EQ(handler_.counters().truncated,
            static_cast<std::uint64_t>(ControlServer::kDatagramsPerTurn));
  control_.tick(kStart + 5ms);
  EXPECT_EQ(task_.ticks, 1);
  EXPECT_EQ(task_.last, kStart + 5ms);
}

TEST_F(ControlServerTest, CountsWhatIsTooLongAndWhatTheSocketLost) {
  port_.inject(Bytes(wire::kMaxDatagram + 1), peer(1));
  receive();
  for (int i = 0; i < 610; ++i) {
    port_.inject(Bytes(10), peer(1));
  }
  const wire::ControlCounters counters = control_counters(handler_, port_);
  EXPECT_EQ(counters.bad_length, 1U);
  EXPECT_EQ(counters.overrun, 10U);
}

// Whoever asks a whole link from the port that all of it hear is answered there, and nowhere else.
TEST_F(ControlServerTest, AnswersALinkByBroadcast) {
  hal::emu::DatagramPort broadcasts{10};
  ControlServer control{{.port = port_,
                         .handler = handler_,
                         .subscribers = subscribers_,
                         .ring = ring_,
                         .tasks = tasks_,
                         .link = &broadcasts}};
  const auto turn = [&] {
    EXPECT_EQ(control.receive(hal::Duration::zero(), []() noexcept { return kStart; }),
              Status::kOk);
  };
  constexpr std::uint32_t kInterface = 3;
  port_.inject(discover(4), peer(1, firmware::kLinkPort), kInterface);
  turn();
  EXPECT_TRUE(answers().empty());
  const auto sent = broadcasts.take_sent();
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->to, firmware::all_of_link(kInterface));
  EXPECT_EQ(sent->to.port, 7561);
  EXPECT_EQ(sent->to.own, hal::Peer{}.own);
  // From any other port, or to the sensor's own address: to that host alone.
  port_.inject(discover(5), peer(1), kInterface);
  port_.inject(discover(6), peer(2, firmware::kLinkPort));
  turn();
  const auto all = answers();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].first, peer(1));
  EXPECT_EQ(all[1].first, peer(2, firmware::kLinkPort));
  EXPECT_FALSE(broadcasts.take_sent());
}

}  // namespace
}  // namespace stof::test
