#include "host/netem/relay.h"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "posix/udp_socket.h"
#include "tests/support/loopback.h"

// Through a relay on loopback. Nothing waits for a time: the relay runs until what was sent is
// there.
namespace stof::netem {
namespace {

using std::chrono::milliseconds;

// A socket at a free port of loopback.
class Peer {
 public:
  Peer() { EXPECT_EQ(socket_.bind(test::loopback_address(0)), 0); }
  std::uint16_t port() const { return socket_.port(); }
  void send_to(const posix::SocketAddress& to, std::string_view text) {
    EXPECT_EQ(socket_.send_to(to, std::as_bytes(std::span(text))), 0);
  }
  void send_to(std::uint16_t port, std::string_view text) {
    send_to(test::loopback_address(port), text);
  }
  // What lies there; from: who sent it.
  std::optional<std::string> receive() {
    std::array<char, 2000> buffer{};
    const auto size = socket_.receive(std::as_writable_bytes(std::span(buffer)), &from);
    return size ? std::optional(std::string(buffer.data(), *size)) : std::nullopt;
  }
  std::string wait_for(Relay& relay) {
    for (int i = 0; i < 2000; ++i) {
      if (const auto text = receive()) {
        return *text;
      }
      EXPECT_TRUE(relay.run(milliseconds(5)));
    }
    return "nothing came";
  }

  posix::SocketAddress from;

 private:
  posix::UdpSocket socket_{AF_INET};
};

class RelayTest : public testing::Test {
 protected:
  void open(RelayOptions options = {}) {
    options.listen_address = "127.0.0.1";
    options.upstream = "127.0.0.1:" + std::to_string(sensor_.port());
    auto relay = Relay::open(options);
    ASSERT_TRUE(relay) << relay.error();
    relay_ = std::move(*relay);
  }

  Peer sensor_;
  Peer first_;
  Peer second_;
  std::unique_ptr<Relay> relay_;
};

TEST_F(RelayTest, AnswersGoToTheClientThatAsked) {
  open();
  first_.send_to(relay_->port(), "one");
  EXPECT_EQ(sensor_.wait_for(*relay_), "one");
  const posix::SocketAddress first = sensor_.from;
  second_.send_to(relay_->port(), "two");
  EXPECT_EQ(sensor_.wait_for(*relay_), "two");
  const posix::SocketAddress second = sensor_.from;
  EXPECT_FALSE(first == second);
  sensor_.send_to(second, "for two");
  sensor_.send_to(first, "for one");
  EXPECT_EQ(first_.wait_for(*relay_), "for one");
  EXPECT_EQ(second_.wait_for(*relay_), "for two");
  EXPECT_EQ(relay_->counts().clients, 2U);
  EXPECT_EQ(relay_->counts().up.out, 2U);
  EXPECT_EQ(relay_->counts().down.out, 2U);
}

TEST_F(RelayTest, IsBadOnTheWayThatWasNamedOnly) {
  open({.impairment = {.loss = 1}, .only = Direction::kDown});
  first_.send_to(relay_->port(), "hello");
  EXPECT_EQ(sensor_.wait_for(*relay_), "hello");
  sensor_.send_to(sensor_.from, "answer");
  for (int i = 0; i < 200 && relay_->counts().down.lost == 0; ++i) {
    EXPECT_TRUE(relay_->run(milliseconds(5)));
  }
  EXPECT_EQ(relay_->counts().down.lost, 1U);
  EXPECT_EQ(relay_->counts().down.out, 0U);
  EXPECT_FALSE(first_.receive());
}

TEST_F(RelayTest, ASensorThatIsNotThereYetIsNoError) {
  RelayOptions options;
  {
    const Peer gone;
    options = {.listen_address = "127.0.0.1",
               .upstream = "127.0.0.1:" + std::to_string(gone.port())};
  }
  const auto relay = Relay::open(options);
  ASSERT_TRUE(relay);
  for (int i = 0; i < 5; ++i) {
    first_.send_to((*relay)->port(), "hello");
    EXPECT_TRUE((*relay)->run(milliseconds(2)));
  }
  EXPECT_EQ((*relay)->counts().clients, 1U);
}

TEST_F(RelayTest, TakesAsManyClientsAsItSays) {
  open();
  std::vector<Peer> clients(65);
  for (Peer& client : clients) {
    client.send_to(relay_->port(), "x");
    EXPECT_TRUE(relay_->run(milliseconds(0)));
  }
  EXPECT_TRUE(relay_->run(milliseconds(5)));
  EXPECT_EQ(relay_->counts().clients, 64U);
}

TEST(RelayErrors, SayWhatIsWrongInOneLine) {
  for (const char* upstream : {"", "nowhere", ":7560", "host:", "127.0.0.1:port", "[::1"}) {
    const auto relay = Relay::open({.upstream = upstream});
    ASSERT_FALSE(relay) << upstream;
    EXPECT_NE(relay.error().find(std::string("'") + upstream + "'"), std::string::npos);
    EXPECT_EQ(relay.error().find('\n'), std::string::npos);
  }
  EXPECT_FALSE(Relay::open({.listen_address = "no.such", .upstream = "127.0.0.1:1"}));
  const Peer taken;
  const auto relay = Relay::open(
      {.listen_address = "127.0.0.1", .listen_port = taken.port(), .upstream = "127.0.0.1:1"});
  ASSERT_FALSE(relay);
  EXPECT_NE(relay.error().find(std::to_string(taken.port())), std::string::npos);
}

TEST(RelayErrors, TakeAnAddressOfTheNewInternet) {
  EXPECT_TRUE(Relay::open({.listen_address = "127.0.0.1", .upstream = "[::1]:7560"}));
}

}  // namespace
}  // namespace stof::netem
