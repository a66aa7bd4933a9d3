#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/control/cookie.h"
#include "firmware/control/lease_table.h"
#include "firmware/control/link_way.h"
#include "firmware/control/request_limits.h"
#include "firmware/control/settings_service.h"
#include "firmware/keys/authenticator.h"
#include "firmware/keys/pairing_server.h"
#include "firmware/wire/keys/signed_packet.h"
#include "firmware/wire/messages/announce.h"
#include "firmware/wire/messages/discover.h"
#include "firmware/wire/messages/subscribe.h"
#include "firmware/wire/messages/subscribed.h"
#include "firmware/wire/packet.h"
#include "hal/datagram_port.h"
#include "hal/time.h"

namespace stof::firmware {

// Judges every datagram that comes to the sensor's port: any bytes in, at most one answer out.
//
// Without a valid cookie a source gets one answer a request, never longer than that request, and
// how many leave is limited (RequestLimits). What is signed is judged after all that, since it
// costs most: a key that nobody has takes no more of the processor than a host's share. Over a link
// (link_way.h) all is the same, but nobody subscribes, and only a discover may go to any sensor. No
// clock, no socket, no heap; for one thread, except counters().
class RequestHandler {
 public:
  // All outlive the handler. settings nullptr: every request for them is answered with
  // kUnsupported. authenticator nullptr: no key is known, and nobody changes anything.
  RequestHandler(const wire::Origin& origin, const CookieSecret& secret, LeaseTable& subscribers,
                 SettingsService* settings, keys::Authenticator* authenticator = nullptr) noexcept;

  // Who serves requests to pair; outlives the handler. Before, all are answered with kClosed.
  void set_pairing(keys::PairingServer* pairing) noexcept { pairing_ = pairing; }
  // The answer to a discover; request_id and subscribers are filled in here.
  void set_announce(const wire::Announce& announce, wire::Health health) noexcept;

  // One datagram. The answer for `from`, valid until the next call; empty: none.
  std::span<const std::byte> take(std::span<const std::byte> datagram, const hal::Peer& from,
                                  hal::Time now) noexcept;
  // A datagram of which only the first bytes were kept.
  void take_oversized() noexcept { count(Count::kBadLength); }

  // For any thread. `overrun` is the port's and 0 here.
  wire::ControlCounters counters() const noexcept;

 private:
  enum class Count : std::uint8_t {
    kAccepted,
    kTruncated,
    kBadMagic,
    kBadVersion,
    kBadLength,
    kBadCrc,
    kBadField,
    kNotControl,
    kForeign,
    kTooShort,
    kCookies,
    kBusy,
    kForged,
    kReplayed
  };
  static constexpr std::size_t kCounts = 14;

  // One request, verified, for us.
  struct Request {
    const wire::PacketView& packet;
    const hal::Peer& from;
    hal::Time now;
    std::span<const std::byte> datagram;  // as a whole
  };
  using Answer = std::span<const std::byte>;
  // A request that a key signs, and what is the same in all that may be signed.
  struct SignedRequest {
    const Request& request;
    const wire::SignedView& view;
    wire::PacketType type;  // kSubscribe, kUnsubscribe, kSettingsRequest
    std::uint32_t request_id = 0;
    std::uint64_t cookie = 0;
    const wire::Key* key = nullptr;  // once it is known
  };
  static std::optional<SignedRequest> read_signed(const Request& request,
                                                  const wire::SignedView& view) noexcept;
  // Whom a request is of, for those who note it: over a link anybody, whatever address it has.
  static hal::Peer asker_of(const Request& request) noexcept;

  // What has ended must not keep anybody out until the next turn of the thread.
  void drop_ended(hal::Time now) noexcept;
  Answer subscribe(const Request& request) noexcept;
  Answer serve_settings(const Request& request) noexcept;
  Answer serve_signed(const Request& request) noexcept;
  // What a key signed, judged: writes the message that answers it into `payload`; its bytes.
  std::size_t serve_subscribe(const SignedRequest& request, std::span<std::byte> payload) noexcept;
  std::size_t serve_stale(const SignedRequest& request, std::span<std::byte> payload) noexcept;
  Answer pair(const Request& request) noexcept;
  Answer discover(const Request& request) noexcept;
  // Whether an answer of `payload_bytes` may go to a source that has proven nothing.
  bool may_answer_unproven(const Request& request, std::size_t payload_bytes) noexcept;
  // Whether a source that showed a valid cookie is served now.
  bool may_serve(const Request& request) noexcept;
  Answer answer(const Request& request, const wire::Subscribed& subscribed) noexcept;
  // To a source without a valid cookie, or one of another session.
  Answer answer_cookie(const Request& request, std::uint32_t request_id) noexcept;
  Answer subscribe_cookie(const Request& request, std::uint32_t request_id) noexcept;
  Answer unknown_key(const SignedRequest& request) noexcept;
  // Fills in what every one has, and writes it.
  void put_subscribed(wire::Subscribed subscribed, const Request& request,
                      std::span<std::byte> payload) noexcept;
  Answer answer(const wire::SettingsAnswer& settings, std::size_t text_bytes) noexcept;
  // Serves a request whose text follows it, and writes the answer and its text into `payload`.
  // Returns the bytes of both.
  std::size_t serve(const wire::SettingsRequest& asked, std::span<const std::byte> text,
                    const Request& request, Access access, std::uint32_t key_id,
                    std::span<std::byte> payload) noexcept;
  Answer seal(wire::PacketType type, std::size_t payload_bytes) noexcept;
  Answer refuse(Count why) noexcept;
  void count(Count what) noexcept;
  static Count reason(wire::PacketFault fault) noexcept;

  wire::Origin origin_;
  Cookies cookies_;
  LeaseTable& subscribers_;
  SettingsService* settings_;
  keys::Authenticator* authenticator_;
  keys::PairingServer* pairing_ = nullptr;
  RequestLimits limits_;
  wire::Announce announce_{};
  wire::Health health_ = wire::Health::kOk;
  wire::DatagramBuffer buffer_{};
  std::array<std::atomic<std::uint64_t>, kCounts> counts_{};
};

}  // namespace stof::firmware
