#include <array>
#include <chrono>

#include "firmware/control/request_handler.h"
#include "firmware/keys/key_service.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/settings_server.h"
#include "firmware/wire/crypto/crypto.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/fuzz/fuzz_input.h"

// Requests behind the tag: whoever has a key may send any payload of any type. Each record's first
// byte is the type within the signed packet, its flags say whose key signs it (kSeal: a good tag).
// What a role may not do changes nothing.
namespace stof {
namespace {

constexpr wire::Origin kHere{.device_id = 1, .session_id = 77};
constexpr std::size_t kCookieAt = 8;

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
    fuzz::require(may_change);
    fuzz::require(revision > newest_);
    newest_ = revision;
    return true;
  }
  bool may_change = false;

 private:
  std::uint32_t newest_ = 1;
};

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  static const bool ready = wire::start_crypto();
  fuzz::require(ready);
  const std::array keys{test::numbered_key(11, wire::Role::kAdmin),
                        test::numbered_key(12, wire::Role::kTune),
                        test::numbered_key(13, wire::Role::kView)};
  keys::Keyring ring(nullptr, nullptr);
  for (const wire::Key& key : keys) {
    fuzz::require(ring.add(key) == Status::kOk);
  }
  keys::Authenticator authenticator(ring);
  AnyLimits limits;
  CheckingSink sink;
  settings::SettingsServer server({}, {}, {.limits = limits, .sink = sink});
  firmware::LeaseTable subscribers;
  const firmware::CookieSecret secret{};
  firmware::RequestHandler handler(kHere, secret, subscribers, &server, &authenticator);
  const hal::Peer peer{.address = {1, 2, 3}, .port = 9000};
  hal::Time now{std::chrono::seconds(1'000'000)};
  std::uint64_t counter = 0;

  fuzz::for_each_record(input, [&](const fuzz::Record& record) {
    if (record.bytes.empty()) {
      return;
    }
    now += std::chrono::seconds(record.seconds());
    const wire::Key& key = keys[record.peer() % keys.size()];
    wire::DatagramBuffer buffer{};
    const std::span<std::byte> payload = wire::signed_space(buffer);
    const auto inner =
        record.bytes.subspan(1).first(std::min(record.bytes.size() - 1, payload.size()));
    std::ranges::copy(inner, payload.begin());
    if (inner.size() >= kCookieAt + 8) {
      wire::put_u64(payload.subspan(kCookieAt).first<8>(),
                    firmware::Cookies(secret).make(peer, now));
    }
    wire::Secret with = key.secret;
    const bool good = (record.flags & fuzz::kSeal) != 0;
    with[0] ^= good ? std::byte{0} : std::byte{1};
    const auto datagram =
        wire::seal_signed({.type = wire::PacketType::kSignedRequest, .origin = kHere},
                          {.key_id = key.id,
                           .type = static_cast<std::uint8_t>(record.bytes[0]),
                           .counter = ++counter},
                          inner.size(), with, buffer);
    sink.may_change = good && key.role != wire::Role::kView;
    const std::span<const std::byte> answer = handler.take(datagram, peer, now);
    fuzz::require(answer.empty() || wire::parse_packet(answer).has_value());
  });
  fuzz::require(ring.keys().count() == keys.size());
}
