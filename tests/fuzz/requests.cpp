#include <array>
#include <chrono>

#include "firmware/control/request_handler.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/settings_server.h"
#include "firmware/wire/messages/settings_answer.h"
#include "tests/fuzz/fuzz_input.h"

// Requests to the sensor's port, from four sources, with settings behind it. Whoever shows no
// cookie never gets more bytes than it sent.
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
  return packet && packet->payload.size() >= kCookieAt + 8 &&
         firmware::Cookies(kSecret).valid(
             wire::get_u64(packet->payload.subspan(kCookieAt).first<8>()), peer, now);
}

void learn(const wire::PacketView& answer, std::uint64_t& cookie) {
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
  firmware::RequestHandler handler({.device_id = 0x0A0B0C0D, .session_id = 1}, kSecret, subscribers,
                                   &server);
  hal::Time now{std::chrono::seconds(1000)};
  std::array<std::uint64_t, 4> cookies{};
  std::uint64_t taken = 0;

  fuzz::for_each_record(input, [&](const fuzz::Record& record) {
    now += std::chrono::seconds(record.seconds());
    const hal::Peer peer{.address = {1, 2, 3},
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
    const std::span<const std::byte> answer = handler.take(bytes, peer, now);
    ++taken;
    if (!answer.empty()) {
      fuzz::require(answer.size() <= bytes.size() || proven(bytes, peer, now));
      const auto packet = wire::parse_packet(answer);
      fuzz::require(packet.has_value());
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
