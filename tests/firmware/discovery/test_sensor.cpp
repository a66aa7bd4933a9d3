// test_sensor SERIAL NAME PORT: beacon, multicast DNS and answers to `discover`, as a sensor gives
// them, until SIGTERM.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "firmware/discovery/beacon.h"
#include "firmware/discovery/mdns_agent.h"
#include "firmware/wire/messages/discover.h"
#include "hal/linux/ports/mdns_port.h"
#include "hal/linux/ports/network_interfaces.h"
#include "hal/linux/ports/udp_port.h"
#include "hal/linux/system/clock.h"

namespace {

volatile std::sig_atomic_t stopping = 0;
constexpr stof::wire::FrameStamp kStamp{.health = stof::wire::Health::kDegraded};

template <typename Text>
void put_text(Text& out, const char* text) {
  std::memcpy(out.data(), text, std::min(out.size(), std::strlen(text)));
}

void answer(stof::hal::linux::UdpPort& port, stof::wire::Announce announce,
            const stof::wire::Origin& origin) {
  namespace wire = stof::wire;
  wire::DatagramBuffer buffer{};
  const auto received = port.receive(buffer, std::chrono::milliseconds(10));
  const auto packet =
      received
          ? wire::parse_packet(std::span(buffer).first(std::min(received->bytes, buffer.size())))
          : std::unexpected(wire::PacketFault::kTruncated);
  if (!packet || packet->header.type != wire::PacketType::kDiscover) {
    return;
  }
  announce.request_id = wire::decode_discover(packet->payload).value().request_id;
  wire::DatagramBuffer space{};
  const auto datagram = stof::firmware::seal_announce(announce, origin, kStamp, space);
  std::size_t sent = 0;
  static_cast<void>(port.send(received->from, std::span(&datagram, 1), sent));
}

}  // namespace

int main(int argc, char** argv) {
  using namespace stof;
  if (argc != 4) {
    return 2;
  }
  std::signal(SIGTERM, [](int) { stopping = 1; });
  hal::linux::Clock clock;
  hal::linux::NetworkInterfaces network;
  auto port = hal::linux::UdpPort::open(
      {.port = static_cast<std::uint16_t>(std::strtol(argv[3], nullptr, 10))});
  auto broadcasts = hal::linux::UdpPort::open({.ipv4_only = true, .broadcast = true});
  auto mdns = hal::linux::MdnsPort::open();
  if (!port || !broadcasts || !mdns) {
    std::puts("a port cannot be had");
    return 1;
  }
  firmware::Service service{.announce = {.port = (*port)->port(), .most_subscribers = 4},
                            .device_id = 0x0a0b0c0d};
  put_text(service.announce.serial, argv[1]);
  put_text(service.announce.name, argv[2]);
  put_text(service.announce.version, "0.1.0");
  put_text(service.announce.board, "emu");
  service.announce.rate_millihertz = 29'970;
  const wire::Origin origin{.device_id = service.device_id, .session_id = 1};
  firmware::Beacon beacon(broadcasts->get(), network);
  beacon.set(service.announce, origin, kStamp);
  firmware::MdnsAgent agent(**mdns, network, service, service.device_id);
  std::printf("port %d\n", (*port)->port());
  std::fflush(stdout);
  while (stopping == 0) {
    beacon.tick(clock.now());
    agent.tick(clock.now());
    answer(**port, service.announce, origin);
  }
  agent.stop(clock.now());
  return 0;
}
