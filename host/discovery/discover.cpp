#include "host/discovery/discover.h"

#include <algorithm>
#include <array>
#include <optional>
#include <random>

#include "firmware/wire/dns.h"
#include "firmware/wire/messages/discover.h"
#include "host/client/control/control_client.h"
#include "host/client/control/known_sensors.h"
#include "host/discovery/discovery_socket.h"
#include "posix/interfaces.h"
#include "posix/poll.h"

namespace stof::client {
namespace {

namespace dns = wire::dns;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::uint16_t kMdnsPort = 5353;
constexpr std::array<std::byte, 4> kGroup4{std::byte{224}, std::byte{0}, std::byte{0},
                                           std::byte{251}};

// When questions are asked: any of them may be lost.
constexpr std::array kAsk{0ms, 300ms, 1000ms, 1900ms};
constexpr auto kAnswered = 500ms;  // what comes later may be a sensor that has started again

in_addr address4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
  return in_addr{.s_addr = htonl((std::uint32_t{a} << 24) | (std::uint32_t{b} << 16) |
                                 (std::uint32_t{c} << 8) | d)};
}

std::vector<std::byte> seal_question(std::uint32_t request_id) {
  wire::DatagramBuffer buffer;
  wire::encode_discover({.request_id = request_id},
                        wire::payload_space(buffer).first<wire::kDiscoverBytes>());
  const auto packet =
      wire::seal_packet({.type = wire::PacketType::kDiscover}, wire::kDiscoverBytes, buffer);
  return {packet.begin(), packet.end()};
}

// From a port of our own, so that everybody answers us alone. A sensor answers with no more bytes
// than it was asked with: padding (RFC 7830) makes room.
std::vector<std::byte> mdns_question() {
  std::array<std::byte, 512> buffer{};
  dns::Writer writer(buffer, 0, 0);
  static_cast<void>(
      writer.question({"_stof", "_udp", "local"}, dns::Type::kPtr, dns::kInternet | dns::kTopBit));
  constexpr auto kOpt = static_cast<dns::Type>(41);
  constexpr std::uint16_t kPadding = 12;
  constexpr std::size_t kOptBytes = 15;  // without its padding
  constexpr std::uint16_t kUdpBytes = 1440;
  const std::vector<std::byte> padding(buffer.size() - writer.message().size() - kOptBytes);
  writer.begin_record({}, kOpt, kUdpBytes, 0);
  writer.data_u16(kPadding);
  writer.data_u16(static_cast<std::uint16_t>(padding.size()));
  writer.data(padding);
  static_cast<void>(writer.finish(dns::Writer::Section::kAdditional));
  const auto message = writer.message();
  return {message.begin(), message.end()};
}

// HOST[:PORT]; nothing: not an address, not a known name.
std::optional<posix::SocketAddress> look_up(const std::string& text) {
  const auto target = posix::split_host_port(text, kSensorPort);
  const auto found =
      target ? posix::resolve(*target, posix::Names::kLookUp) : std::unexpected(std::string());
  return found ? std::optional(found->front()) : std::nullopt;
}

class Search {
 public:
  explicit Search(std::vector<posix::SocketAddress> asked)
      : asked_(std::move(asked)), question_(seal_question(std::random_device{}() | 1U)) {}

  bool any_open() const { return ask4_.is_open() || ask6_.is_open() || beacons_.is_open(); }

  void end_answers() { found_.end_answers(); }

  void ask() {
    found_.begin_answers();
    const posix::Interfaces interfaces = posix::list_interfaces();
    std::vector<in_addr> near = interfaces.broadcasts;
    near.push_back(address4(127, 0, 0, 1));
    for (const in_addr& address : near) {
      ask4_.send(posix::make_address(address, kSensorPort), question_);
    }
    for (const posix::SocketAddress& address : asked_) {
      ask4_.send(address, question_);
      ask6_.send(address, question_);
    }
    in_addr group4{};
    std::ranges::copy(kGroup4, std::as_writable_bytes(std::span(&group4, 1)).begin());
    in6_addr group6{};
    group6.s6_addr[0] = 0xff;
    group6.s6_addr[1] = 0x02;
    group6.s6_addr[15] = 0xfb;
    const posix::SocketAddress all = posix::make_address(address4(255, 255, 255, 255), kSensorPort);
    // From its port they are answered there, by broadcast, whatever their addresses are.
    for (const unsigned interface : interfaces.links) {
      ask4_.send_by(interface, all, question_);
      beacons_.send_by(interface, all, question_);
    }
    in6_addr hosts6{};  // all on the link
    hosts6.s6_addr[0] = 0xff;
    hosts6.s6_addr[1] = 0x02;
    hosts6.s6_addr[15] = 0x01;
    for (const unsigned interface : interfaces.multicast) {
      ask6_.send_by(interface, posix::make_address(hosts6, kSensorPort, interface), question_);
      mdns4_.send_by(interface, posix::make_address(group4, kMdnsPort), mdns_question_);
      mdns6_.send_by(interface, posix::make_address(group6, kMdnsPort, interface), mdns_question_);
    }
  }

  // Blocks until something has come or the time is there.
  void wait(Clock::time_point until) const {
    std::array<pollfd, 5> fds{};
    std::ranges::transform(sockets_, fds.begin(), [](const DiscoverySocket* socket) {
      return pollfd{.fd = socket->fd(), .events = POLLIN, .revents = 0};
    });
    static_cast<void>(posix::wait_for(fds, std::min<Clock::duration>(until - Clock::now(), 1s)));
  }

  void take() {
    // Somebody who floods us does not keep us: then it is looked at the clock.
    constexpr int kMost = 100;
    std::array<std::byte, 9000> space{};  // the longest of multicast DNS
    for (const DiscoverySocket* socket : sockets_) {
      for (int i = 0; i < kMost; ++i) {
        const auto read = socket->receive(space);
        if (!read) {
          break;
        }
        take(*socket, *read);
      }
    }
  }

  std::vector<FoundSensor> result() const { return found_.sorted(); }
  // Of one that has answered itself.
  bool has_answer(const std::function<bool(const FoundSensor&)>& wanted) const {
    return std::ranges::any_of(result(), [&](const FoundSensor& sensor) {
      return sensor.methods[static_cast<std::size_t>(DiscoveryMethod::kDirect)] && wanted(sensor);
    });
  }

 private:
  void take(const DiscoverySocket& socket, const DiscoverySocket::Read& read) {
    if (&socket == &mdns4_ || &socket == &mdns6_) {
      found_.take_mdns(read.datagram, read.from);
    } else {
      const DiscoveryMethod method =
          &socket == &beacons_ ? DiscoveryMethod::kBeacon : DiscoveryMethod::kDirect;
      static_cast<void>(found_.take_packet(read.datagram, read.from, method));
    }
    // Who is only told of is asked: multicast DNS says nothing of health, and packets should go
    // both ways.
    for (const std::string& endpoint : found_.take_silent()) {
      if (const auto address = look_up(endpoint)) {
        ask4_.send(*address, question_);
        ask6_.send(*address, question_);
      }
    }
  }

  std::vector<posix::SocketAddress> asked_;
  std::vector<std::byte> question_;
  std::vector<std::byte> mdns_question_ = mdns_question();
  DiscoverySocket ask4_{AF_INET, 0};
  DiscoverySocket ask6_{AF_INET6, 0};
  DiscoverySocket mdns4_{AF_INET, 0};
  DiscoverySocket mdns6_{AF_INET6, 0};
  DiscoverySocket beacons_{AF_INET, kBeaconPort};
  std::array<const DiscoverySocket*, 5> sockets_{&ask4_, &ask6_, &mdns4_, &mdns6_, &beacons_};
  FoundSensors found_;
};

}  // namespace

std::expected<std::vector<FoundSensor>, DiscoverError> discover(const DiscoverOptions& options) {
  std::vector<posix::SocketAddress> asked;
  for (const std::string& text : options.addresses) {
    const auto address = look_up(text);
    if (!address) {
      return std::unexpected(DiscoverError{
          "'" + text + "': no such host: give HOST or HOST:PORT, such as 192.168.1.20"});
    }
    asked.push_back(*address);
  }
  Search search(std::move(asked));
  if (!search.any_open()) {
    return std::unexpected(DiscoverError{"the system gives no UDP socket: close other programs"});
  }
  const Clock::time_point begin = Clock::now();
  Clock::time_point end = begin + options.timeout;
  std::size_t asked_times = 0;
  bool found = false;
  for (Clock::time_point now = begin; now < end; now = Clock::now()) {
    if (asked_times < kAsk.size() && now >= begin + kAsk[asked_times]) {
      search.ask();
      ++asked_times;
    }
    const Clock::time_point next =
        asked_times < kAsk.size() ? std::min(end, begin + kAsk[asked_times]) : end;
    search.wait(next);
    if (asked_times > 0 && Clock::now() >= begin + kAsk[asked_times - 1] + kAnswered) {
      search.end_answers();
    }
    search.take();
    if (options.wanted && !found && search.has_answer(options.wanted)) {
      found = true;
      end = std::min(end, Clock::now() + DiscoverOptions::kGrace);
    }
  }
  return search.result();
}

std::expected<FoundSensor, DiscoverError> ask_sensor(const std::string& address,
                                                     std::chrono::milliseconds timeout,
                                                     std::optional<std::uint32_t> device) {
  constexpr int kAttempts = 4;
  auto transport = open_udp_transport(address);
  if (!transport) {
    return std::unexpected(DiscoverError{transport.error().message});
  }
  const std::vector<std::byte> question = seal_question(std::random_device{}() | 1U);
  std::optional<std::uint32_t> other;
  for (int i = 0; i < kAttempts; ++i) {
    static_cast<void>((*transport)->send(question));
    const Clock::time_point end = Clock::now() + timeout / kAttempts;
    for (int behind = 0;;) {
      const auto packet = receive_until(**transport, end, behind);
      if (!packet && packet.error() == Status::kTimeout) {
        break;
      }
      FoundSensors found;
      if (packet && found.take_packet(*packet, {}, DiscoveryMethod::kDirect)) {
        FoundSensor sensor = found.sorted().front();
        if (sensor.device_id != device.value_or(sensor.device_id)) {
          other = sensor.device_id;
          continue;
        }
        const std::string place = (*transport)->place();
        if (const auto at = posix::split_host_port(place)) {
          sensor.address = at->host;
          sensor.port = at->port;
        }
        return sensor;
      }
    }
  }
  return std::unexpected(DiscoverError{
      (*transport)->place() + (other ? ": " + other_sensor(*other, *device)
                                     : ": does not say who it is: check that the sensor runs, its "
                                       "address and the network")});
}

}  // namespace stof::client
