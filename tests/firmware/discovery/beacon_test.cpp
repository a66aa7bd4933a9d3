#include "firmware/discovery/beacon.h"

#include <gtest/gtest.h>

#include "hal/emu/devices/network_interfaces.h"
#include "tests/firmware/discovery/mdns_support.h"

namespace stof::firmware::test {
namespace {

using namespace std::chrono_literals;

class SentPort final : public hal::DatagramPort {
 public:
  Status send(const hal::Peer& to, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& count) noexcept override {
    peers.push_back(to);
    packet.assign(datagrams[0].begin(), datagrams[0].end());
    count = 0;
    return Status::kDeviceError;  // nobody there
  }
  Result<hal::Received> receive(std::span<std::byte>, hal::Duration) noexcept override {
    return fail(Status::kTimeout);
  }
  std::uint64_t overruns() const noexcept override { return 0; }
  bool take_unreachable(hal::Peer&) noexcept override { return false; }
  std::uint16_t port() const noexcept override { return 7560; }

  std::vector<hal::Peer> peers;
  std::vector<std::byte> packet;
};

TEST(Beacon, TellsEveryLinkOnceASecond) {
  hal::emu::NetworkInterfaces network;
  std::array addresses{
      hal::InterfaceAddress{.interface = 1,
                            .address = hal::from_ipv4(127, 0, 0, 1),
                            .broadcast = hal::from_ipv4(127, 255, 255, 255)},
      hal::InterfaceAddress{
          .interface = 2, .address = kOwn4, .broadcast = hal::from_ipv4(192, 0, 2, 255)},
      hal::InterfaceAddress{
          .interface = 2, .address = kPeer4, .broadcast = hal::from_ipv4(192, 0, 2, 255)},
      hal::InterfaceAddress{.interface = 3, .address = {0xfe, 0x80}}};
  network.set(addresses);
  SentPort port;
  Beacon beacon(&port, network);
  hal::Time now{50s};
  beacon.tick(now);
  EXPECT_TRUE(port.peers.empty());  // nothing to tell yet
  beacon.set(some_service().announce, {.device_id = 5, .session_id = 6},
             {.health = wire::Health::kDegraded});
  for (int i = 0; i < 100; ++i, now += 20ms) {
    beacon.tick(now);
  }
  ASSERT_EQ(port.peers.size(), 8U);
  EXPECT_EQ(port.peers[0].address, hal::from_ipv4(127, 255, 255, 255));
  EXPECT_EQ(port.peers[1].address, hal::from_ipv4(192, 0, 2, 255));
  EXPECT_EQ(port.peers[1].scope, 0U);
  // From each address by its interface, for who has none of that network.
  for (const std::size_t i : {2U, 3U}) {
    EXPECT_EQ(port.peers[i].address, hal::from_ipv4(255, 255, 255, 255));
    EXPECT_EQ(port.peers[i].scope, 2U);
    EXPECT_EQ(port.peers[i].own, i == 2 ? kOwn4 : kPeer4);
    EXPECT_EQ(port.peers[i].port, 7561);
  }
  EXPECT_EQ(port.peers[4].address, hal::from_ipv4(127, 255, 255, 255));

  const auto packet = wire::parse_packet(port.packet);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->header.type, wire::PacketType::kAnnounce);
  EXPECT_EQ(packet->header.origin.device_id, 5U);
  EXPECT_EQ(packet->header.frame.health, wire::Health::kDegraded);
  const auto announce = wire::decode_announce(packet->payload);
  ASSERT_TRUE(announce);
  EXPECT_EQ(announce->port, 7560);
  EXPECT_EQ(text_of(announce->serial), "A17");
  EXPECT_EQ(announce->request_id, 0U);
}

}  // namespace
}  // namespace stof::firmware::test
