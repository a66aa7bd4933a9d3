#include <array>
#include <chrono>

#include "firmware/control/request_handler.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/settings_server.h"
#include "firmware/wire/messages/settings_answer.h"
#include "tests/fuzz/fuzz_input.h"

// Requests to the sensor's port, from four sources, one of them by broadcast, with settings behind
// it. Whoever shows no cookie never gets more bytes than it sent; nobody subscribes by broadcast.
namespace stof {
namespace {

class AnyLimits final : public settings::Limits {
 public:
  bool accepts(const settings::Settings& /*settings*/,
               settings::PagedWriter& /*why*/) noexcept override {
    return true;
  }
};

class CheckingSink final : public settings::SettingsSink {
 public:
  bool apply(const settings::Settings& settings, std::uint32_t revision) noexcept override {
    std::array<char, settings::kWhyBytes> space;
    settings::PagedWriter why(space);
    fuzz::require(settings::usable(settings, nullptr, why));
    fuzz::require(revision > newest_);
    newest_ = revision;
    return true;
  }

 private:
  std::uint32_t newest_ = 1;
};

// Of subscribe, settings_request and subscribed; of settings_answer.
constexpr std::size_t kCookieAt = 8;
constexpr std::size_t kAnswerCookieAt = 16;

constexpr firmware::CookieSecret kSecret{};

// libFuzzer sees what its input is compared with and can guess a cookie from that.
bool proven(std::span<const std::byte> request, const hal::Peer& peer, hal::Time now) {
  const auto packet = wire::parse_packet(request);
  if (!packet) {
    return false;
  }
  const std::size_t before =
      packet->header.type == wire::PacketType::kSignedRequest ? wire::kSignedFieldsBytes : 0;
  return packet->payload.size() >= before + kCookieAt + 8 &&
         firmware::Cookies(kSecret).valid(
             wire::get_u64(packet->payload.subspan(before + kCookieAt).first<8>()), peer, now);
}

constexpr unsigned kOverLink = 2;  // the source that asks by broadcast
constexpr unsigned kHolder = 3;    // the source that has a key, and signs with it
constexpr wire::Origin kSensor{.device_id = 0x0A0B0C0D, .session_id = 1};

wire::Key holders_key() {
  return {.id = 1,
          .device = kSensor.device_id,
          .role = wire::Role::kAdmin,
          .name = wire::key_name("a")};
}

// A request that may be signed, as the holder of the key signs it; else as it is.
std::span<const std::byte> signed_by_holder(std::span<const std::byte> request,
                                            std::uint64_t counter, wire::DatagramBuffer& space) {
  const auto packet = wire::parse_packet(request);
  if (!packet || packet->payload.size() > wire::kMaxSignedPayload) {
    return request;
  }
  const wire::Key key = holders_key();
  std::ranges::copy(packet->payload, wire::signed_space(space).begin());
  return wire::seal_signed({.type = wire::PacketType::kSignedRequest, .origin = kSensor},
                           {.key_id = key.id,
                            .type = static_cast<std::uint8_t>(packet->header.type),
                            .counter = counter},
                           packet->payload.size(), key.secret, space);
}

void learn(const wire::PacketView& answer, std::uint64_t& cookie) {
  if (answer.header.type == wire::PacketType::kSignedAnswer) {
    fuzz::require(answer.payload.size() >= wire::kSignedFieldsBytes + sizeof(wire::Tag));
    return;
  }
  const bool settings = answer.header.type == wire::PacketType::kSettingsAnswer;
  const std::size_t at = settings ? kAnswerCookieAt : kCookieAt;
  if (answer.header.type == wire::PacketType::kSubscribed || settings) {
    cookie = wire::get_u64(answer.payload.subspan(at).first<8>());
  }
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  AnyLimits limits;
  CheckingSink sink;
  settings::SettingsServer server({}, {}, {.limits = limits, .sink = sink});
  firmware::LeaseTable subscribers;
  require(wire::start_crypto());
  keys::Keyring ring(nullptr, nullptr);
  require(ring.add(holders_key()) == Status::kOk);
  keys::Authenticator authenticator(ring);
  firmware::RequestHandler handler(kSensor, kSecret, subscribers, &server, &authenticator);
  std::uint64_t counter = 0;
  hal::Time now{std::chrono::seconds(1000)};
  std::array<std::uint64_t, 4> cookies{};
  std::uint64_t taken = 0;

  fuzz::for_each_record(input, [&](const fuzz::Record& record) {
    now += std::chrono::seconds(record.seconds());
    const bool over_link = record.peer() == kOverLink;
    const hal::Peer peer =
        over_link ? hal::Peer{.address = hal::from_ipv4(10, 0, 0, 5),
                              .port = firmware::kLinkPort,
                              .scope = 2}
                  : hal::Peer{.address = {1, 2, 3},
                              .port = static_cast<std::uint16_t>(9000 + record.peer())};
    wire::DatagramBuffer request{};
    wire::DatagramBuffer space{};
    std::span<const std::byte> bytes =
        record.bytes.first(std::min(record.bytes.size(), request.size()));
    std::ranges::copy(bytes, request.begin());
    if ((record.flags & fuzz::kCookie) != 0 && bytes.size() >= wire::kHeaderBytes + 20) {
      wire::put_u64(std::span(request).subspan(wire::kHeaderBytes + kCookieAt).first<8>(),
                    cookies[record.peer()]);
    }
    bytes = std::span(request).first(bytes.size());
    if ((record.flags & fuzz::kSeal) != 0) {
      bytes = fuzz::sealed(bytes, space);
    }
    wire::DatagramBuffer signed_space{};
    if (record.peer() == kHolder) {
      counter += record.seconds() == 15 ? 0 : 1;  // else it is repeated
      bytes = signed_by_holder(bytes, counter, signed_space);
    }
    const std::span<const std::byte> answer = handler.take(bytes, peer, now);
    ++taken;
    if (!answer.empty()) {
      fuzz::require(answer.size() <= bytes.size() || proven(bytes, peer, now));
      const auto packet = wire::parse_packet(answer);
      fuzz::require(packet.has_value());
      fuzz::require(!over_link || packet->header.type != wire::PacketType::kSubscribed);
      learn(*packet, cookies[record.peer()]);
    }
    fuzz::require(subscribers.count() <= 4);
    subscribers.expire(now);
  });

  const wire::ControlCounters counters = handler.counters();
  fuzz::require(taken == counters.accepted + counters.truncated + counters.bad_magic +
                             counters.bad_version + counters.bad_length + counters.bad_crc +
                             counters.bad_field + counters.not_control + counters.foreign +
                             counters.too_short + counters.cookies + counters.busy +
                             counters.forged + counters.replayed);
}
