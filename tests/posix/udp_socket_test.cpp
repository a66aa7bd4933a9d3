#include "posix/udp_socket.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "posix/datagram_batch.h"
#include "posix/poll.h"
#include "tests/support/loopback.h"
#include "tests/support/udp_abilities.h"

namespace stof::posix {
namespace {

using Bytes = std::vector<std::byte>;

class UdpSocketTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(socket_.bind(test::loopback_address(0)), 0);
    ASSERT_EQ(sender_.connect(test::loopback_address(socket_.port())), 0);
  }
  void wait() const {
    std::array entries{pollfd{.fd = socket_.fd(), .events = POLLIN, .revents = 0}};
    ASSERT_EQ(wait_for(entries, std::chrono::minutes(1)), 1);
  }

  UdpSocket socket_{AF_INET};
  UdpSocket sender_{AF_INET};
  std::unique_ptr<DatagramBatch> batch_ = std::make_unique<DatagramBatch>();
};

TEST_F(UdpSocketTest, AnswersGoBackToWhoAsked) {
  ASSERT_EQ(sender_.send(Bytes(3)), 0);
  wait();
  Bytes space(100);
  SocketAddress from;
  ASSERT_EQ(socket_.receive(space, &from), 3U);
  EXPECT_EQ(from, test::loopback_address(sender_.port()));
  ASSERT_EQ(socket_.send_to(from, Bytes(5)), 0);
  std::array entries{pollfd{.fd = sender_.fd(), .events = POLLIN, .revents = 0}};
  ASSERT_EQ(wait_for(entries, std::chrono::minutes(1)), 1);
  EXPECT_EQ(sender_.receive(space), 5U);
}

TEST_F(UdpSocketTest, NeverBlocks) {
  Bytes space(100);
  EXPECT_EQ(socket_.receive(space), std::unexpected(EAGAIN));
  EXPECT_EQ(batch_->read(socket_.fd()), std::unexpected(EAGAIN));
  std::array entries{pollfd{.fd = socket_.fd(), .events = POLLIN, .revents = 0}};
  EXPECT_EQ(wait_for(entries, std::chrono::milliseconds(1)), 0);
  EXPECT_EQ(wait_for(entries, std::chrono::milliseconds(-1)), 0);
}

TEST_F(UdpSocketTest, ABatchHoldsManyDatagramsAndTellsWhatIsTooLong) {
  for (const std::size_t size : {0U, 1U, 1232U, 2048U, 3000U}) {
    ASSERT_EQ(sender_.send(Bytes(size, std::byte{7})), 0);
  }
  wait();
  ASSERT_EQ(batch_->read(socket_.fd()), 5U);
  EXPECT_EQ(batch_->datagram(0).size(), 0U);
  EXPECT_EQ(batch_->datagram(2).size(), 1232U);
  EXPECT_EQ(batch_->datagram(3).size(), DatagramBatch::kSpace);
  EXPECT_EQ(batch_->datagram(4).size(), DatagramBatch::kSpace);
  EXPECT_EQ(batch_->whole_size(4), 3000U);
  EXPECT_EQ(batch_->datagram(4).back(), std::byte{7});
  EXPECT_EQ(batch_->from(4), test::loopback_address(sender_.port()));
}

TEST_F(UdpSocketTest, DatagramsThatFindTheBufferFullAreCounted) {
  if (!test::counts_overruns()) {
    GTEST_SKIP() << "this system does not count datagrams that find the buffer full";
  }
  ASSERT_EQ(socket_.count_drops(), 0);
  EXPECT_GT(socket_.set_buffer(UdpSocket::Buffer::kReceive, 4096), 0);
  constexpr std::size_t kSent = 100;
  for (std::size_t i = 0; i < kSent; ++i) {
    ASSERT_EQ(sender_.send(Bytes(1000)), 0);
  }
  std::size_t read = 0;
  while (const auto count = batch_->read(socket_.fd())) {
    read += *count;
  }
  ASSERT_EQ(sender_.send(Bytes(1)), 0);  // carries the count
  wait();
  ASSERT_EQ(batch_->read(socket_.fd()), 1U);
  EXPECT_EQ(batch_->dropped(), kSent - read);
}

TEST(UdpSocket, IsNotOpenByItselfAndSaysSo) {
  const UdpSocket none;
  EXPECT_FALSE(none.is_open());
  EXPECT_EQ(none.bind(test::loopback_address(0)), EBADF);
  EXPECT_EQ(none.send(Bytes(1)), EBADF);
  EXPECT_EQ(none.port(), 0);
}

TEST(UdpSocket, APortThatIsTakenIsRefused) {
  const UdpSocket first(AF_INET);
  ASSERT_EQ(first.bind(test::loopback_address(0)), 0);
  EXPECT_EQ(UdpSocket(AF_INET).bind(test::loopback_address(first.port())), EADDRINUSE);
}

}  // namespace
}  // namespace stof::posix
