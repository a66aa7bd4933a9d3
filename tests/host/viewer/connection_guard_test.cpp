#include "host/viewer/connection_guard.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

namespace stof::viewer {
namespace {

constexpr int kEnoughMs = 60'000;
constexpr std::string_view kRequest = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";

// What came within `wait_ms`; "" at the end of the connection; none: nothing.
std::optional<std::string> read_some(const posix::Fd& from, int wait_ms) {
  pollfd polled{.fd = from.get(), .events = POLLIN, .revents = 0};
  if (poll(&polled, 1, wait_ms) <= 0) {
    return std::nullopt;
  }
  std::string text(4096, '\0');
  const ssize_t size = recv(from.get(), text.data(), text.size(), 0);
  text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return text;
}

void say(const posix::Fd& to, std::string_view text) {
  ASSERT_EQ(send(to.get(), text.data(), text.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(text.size()));
}

// A guard with a thread of its own, and the server's ends of what it admits.
class ConnectionGuardTest : public testing::Test {
 protected:
  void start(std::chrono::milliseconds patience) {
    guard_ =
        ConnectionGuard::open({.most_waiting = 4, .most_waiting_of_one = 3, .patience = patience},
                              [this](posix::Fd inner, const PageOrigin&) {
                                const std::scoped_lock lock(mutex_);
                                admitted_ = std::move(inner);
                                come_.notify_all();
                              });
    ASSERT_NE(guard_, nullptr);
    thread_ = std::thread([this] { guard_->run(); });
  }
  void TearDown() override {
    if (guard_) {
      guard_->stop();
      thread_.join();
    }
  }
  // From 127.0.0.`last`.
  posix::Fd client(std::uint32_t last) const {
    posix::Fd socket(::socket(AF_INET, SOCK_STREAM, 0));
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK - 1 + last);
    EXPECT_EQ(bind(socket.get(), reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    at.sin_port = htons(guard_->port());
    EXPECT_EQ(connect(socket.get(), reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    return socket;
  }
  posix::Fd admitted() {
    std::unique_lock lock(mutex_);
    come_.wait_for(lock, std::chrono::milliseconds(kEnoughMs),
                   [this] { return admitted_.is_open(); });
    return std::move(admitted_);
  }
  static bool ends(const posix::Fd& socket) {
    return read_some(socket, kEnoughMs).value_or("it goes on").empty();
  }

  std::unique_ptr<ConnectionGuard> guard_;

 private:
  std::mutex mutex_;
  std::condition_variable come_;
  posix::Fd admitted_;
  std::thread thread_;
};

TEST_F(ConnectionGuardTest, OneMoreOfAnAddressTakesThePlaceOfItsOldest) {
  start(std::chrono::hours(1));
  const posix::Fd first = client(2);
  const posix::Fd second = client(2);
  const posix::Fd third = client(2);
  const posix::Fd other = client(3);
  const posix::Fd fourth = client(2);
  EXPECT_TRUE(ends(first));
  EXPECT_EQ(read_some(other, 0), std::nullopt);
  EXPECT_EQ(read_some(second, 0), std::nullopt);
  // All places are taken: who has the most gives one up.
  const posix::Fd stranger = client(4);
  EXPECT_TRUE(ends(second));
  for (const posix::Fd* const one : {&third, &fourth, &other, &stranger}) {
    EXPECT_EQ(read_some(*one, 0), std::nullopt);
  }
  say(other, kRequest);
  const posix::Fd inner = admitted();
  EXPECT_EQ(read_some(inner, kEnoughMs), kRequest);
}

TEST_F(ConnectionGuardTest, ARequestIsPassedOnAsAWholeAndItsAnswerBack) {
  start(std::chrono::hours(1));
  const posix::Fd page = client(1);
  say(page, kRequest.substr(0, 10));
  say(page, kRequest.substr(10));
  posix::Fd inner = admitted();
  EXPECT_EQ(read_some(inner, kEnoughMs), kRequest);
  say(page, kRequest);  // a second one is nobody's
  say(inner, "HTTP/1.1 200 OK\r\n\r\n");
  inner.reset();
  EXPECT_EQ(read_some(page, kEnoughMs), "HTTP/1.1 200 OK\r\n\r\n");
  EXPECT_TRUE(ends(page));
}

TEST_F(ConnectionGuardTest, WhatIsNoRequestIsGivenUp) {
  start(std::chrono::milliseconds(50));
  const posix::Fd silent = client(1);
  const posix::Fd half = client(1);
  send(half.get(), kRequest.data(), kRequest.size() - 2, MSG_NOSIGNAL);  // or it has gone already
  EXPECT_TRUE(ends(silent));
  EXPECT_TRUE(ends(half));
  const posix::Fd long_one = client(1);
  const std::string much(100'000, 'a');
  send(long_one.get(), much.data(), much.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  EXPECT_TRUE(ends(long_one));
}

TEST_F(ConnectionGuardTest, AWebSocketPassesMaskedFramesAlone) {
  start(std::chrono::hours(1));
  const posix::Fd page = client(1);
  say(page, kRequest);
  posix::Fd inner = admitted();
  EXPECT_EQ(read_some(inner, kEnoughMs), kRequest);
  say(inner, "HTTP/1.1 101 Switching Protocols\r\n\r\n");
  EXPECT_EQ(read_some(page, kEnoughMs), "HTTP/1.1 101 Switching Protocols\r\n\r\n");
  const std::string masked("\x81\x81\x01\x02\x03\x04z", 7);
  say(page, masked);
  EXPECT_EQ(read_some(inner, kEnoughMs), masked);
  say(page, std::string_view("\x81\x01z", 3));
  // A frame whose opcode means nothing in its place.
  EXPECT_EQ(read_some(inner, kEnoughMs), std::string("\x83\x80\0\0\0\0", 6));
  say(inner, "end");
  inner.reset();
  EXPECT_EQ(read_some(page, kEnoughMs), "end");
  EXPECT_TRUE(ends(page));
}

TEST_F(ConnectionGuardTest, AClientThatGoesEndsTheServersEnd) {
  start(std::chrono::hours(1));
  posix::Fd page = client(1);
  say(page, kRequest);
  const posix::Fd inner = admitted();
  EXPECT_EQ(read_some(inner, kEnoughMs), kRequest);
  say(inner, "HTTP/1.1 101 Switching Protocols\r\n\r\n");
  EXPECT_TRUE(read_some(page, kEnoughMs).has_value());
  page.reset();
  EXPECT_TRUE(ends(inner));
}

}  // namespace
}  // namespace stof::viewer
