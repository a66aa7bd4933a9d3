#include "firmware/discovery/mdns.h"

#include <array>
#include <chrono>
#include <string_view>

#include "hal/network_interfaces.h"
#include "tests/fuzz/fuzz_input.h"

// Messages of multicast DNS to the sensor's responder: in its probes, its announcements and after.
namespace stof {
namespace {

template <std::size_t kSize>
void fill(std::array<char, kSize>& text, std::string_view value) {
  std::ranges::copy(value, text.begin());
}

void judge(const firmware::Responder::Datagram& datagram) {
  fuzz::require(datagram.bytes.size() >= 12 && datagram.bytes.size() <= wire::kMaxDatagram);
  fuzz::require(datagram.to.port != 0);
  fuzz::touch(datagram.bytes);
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  firmware::Service service{.announce = {.port = 7560}, .device_id = 1};
  fill(service.announce.serial, "1");
  fill(service.announce.name, "front");
  fill(service.announce.version, "0.1.0");
  fill(service.announce.board, "emu");
  firmware::Responder responder(service, 1);
  const std::array addresses{
      hal::InterfaceAddress{.interface = 2,
                            .address = hal::from_ipv4(10, 0, 0, 1),
                            .prefix_bits = 120,
                            .multicast = true},
      hal::InterfaceAddress{
          .interface = 2, .address = {0xfe, 0x80, 1}, .prefix_bits = 64, .multicast = true}};
  hal::Time now{std::chrono::seconds(10)};
  responder.set_addresses(addresses, now);
  const auto send_all = [&] {
    // Bounded: a responder that always has something to say is a finding.
    int most = 64;
    while (const auto datagram = responder.next(now)) {
      judge(*datagram);
      fuzz::require(--most > 0);
    }
  };
  fuzz::for_each_record(input, [&](const fuzz::Record& record) {
    for (unsigned i = 0; i < 4 * record.seconds(); ++i) {
      now += std::chrono::milliseconds(250);
      send_all();
    }
    const hal::Peer from{
        .address = record.peer() % 2 == 0 ? hal::from_ipv4(10, 0, 0, 9) : addresses[1].address,
        .port = record.peer() < 2 ? firmware::Responder::kPort : std::uint16_t{4711},
        .scope = 2};
    if (const auto datagram = responder.take(record.bytes, from, now)) {
      judge(*datagram);
    }
    send_all();
  });
  responder.stop(now);
  send_all();
}
