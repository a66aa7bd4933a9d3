#include <gtest/gtest.h>

#include "tests/firmware/control/control_client.h"
#include "tests/firmware/keys/signed_requests.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/support/heap_guard.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;

// Every kind of request, answer, refusal and list, through a real port.
TEST(ControlNoHeap, TurnsAndFramesAllocateNothing) {
  auto port = hal::linux::UdpPort::open({});
  auto robot = hal::linux::UdpPort::open({});
  ASSERT_TRUE(port && robot);
  std::uint16_t closed = 0;
  {
    closed = hal::linux::UdpPort::open({}).value()->port();
  }
  firmware::LeaseTable subscribers;
  ASSERT_TRUE(wire::start_crypto());
  const wire::Origin sensor{.device_id = 1};
  const wire::Key key = numbered_key(1);
  keys::Keyring ring_of_keys(nullptr, nullptr);
  ASSERT_EQ(ring_of_keys.add(key), Status::kOk);
  keys::Authenticator authenticator(ring_of_keys);
  keys::PairingServer pairing(sensor, ring_of_keys, keys::LabelCode{});
  firmware::RequestHandler handler(sensor, firmware::CookieSecret{}, subscribers, nullptr,
                                   &authenticator);
  handler.set_pairing(&pairing);
  firmware::ReceiverRing ring;
  firmware::ControlServer control(
      {.port = **port, .handler = handler, .subscribers = subscribers, .ring = ring});
  const firmware::Cookies cookies(firmware::CookieSecret{});
  const hal::Peer self = loopback((*robot)->port());
  const std::uint64_t cookie = cookies.make(self, firmware::control_now());
  std::array<std::byte, wire::kPairRequestBytes> pair{};
  wire::encode_pair_request(
      {.method = wire::PairMethod::kCode, .role = wire::Role::kAdmin, .cookie = cookie}, pair);
  const std::array<Bytes, 10> requests{
      signed_subscribe(key, sensor, 2, {.cookie = cookie}),
      signed_settings(key, sensor, 1, {.cookie = cookie}),
      signed_settings(numbered_key(2), sensor, 1, {.cookie = cookie}),
      sealed(wire::PacketType::kPairRequest, pair),
      subscribe({}),
      subscribe({.cookie = cookie}),
      settings({.cookie = cookie}),
      discover(1),
      Bytes(50),
      Bytes(1400)};
  const Bytes frame(hal::kMaxDatagram);
  const std::array<std::span<const std::byte>, 3> datagrams{frame, frame, frame};
  const RawSocket raw;

  const int before = allocations;
  ASSERT_GT(before, 0);
  for (int i = 0; i < 100; ++i) {
    for (const Bytes& request : requests) {
      std::size_t sent = 0;
      const std::span<const std::byte> bytes = request;
      if (bytes.size() <= hal::kMaxDatagram) {
        static_cast<void>((*robot)->send(loopback((*port)->port()), std::span(&bytes, 1), sent));
      } else {
        raw.send(loopback((*port)->port()), bytes);
      }
    }
    static_cast<void>(control.receive(20ms, &firmware::control_now));
    control.tick(firmware::control_now());
    std::size_t sent = 0;
    static_cast<void>((*port)->send(self, datagrams, sent));
    static_cast<void>((*port)->send(loopback(closed), datagrams, sent));
    static_cast<void>(ring.pop());
  }
  EXPECT_EQ(allocations, before);
  EXPECT_GT(handler.counters().accepted, 100U);
  EXPECT_GT(handler.counters().forged, 50U);
  EXPECT_GT(handler.counters().replayed, 50U);
}

}  // namespace
}  // namespace stof::test
