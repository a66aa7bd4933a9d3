#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/wire/keys/key_table.h"
#include "firmware/wire/keys/signed_stream.h"
#include "firmware/wire/messages/settings_request.h"
#include "firmware/wire/messages/structs.h"
#include "firmware/wire/messages/subscribe.h"
#include "firmware/wire/packet.h"

namespace stof::client {

// Signs the requests to one sensor with the key that its user has of it, and judges the answers.
// Which sensor it is, and its session, the first answer tells.
class RequestSigner {
 public:
  static constexpr std::size_t kAnswerable = 16;  // newest requests whose answers count

  // What an answer carries, verified.
  struct Answer {
    std::span<const std::byte> payload;  // of the message that was signed
    std::uint64_t highest = 0;           // counter that the sensor has taken of this key
    std::uint64_t counter = 0;           // of the request that it answers
  };

  explicit RequestSigner(const wire::KeyTable& keys);

  // Who answered. Once a key is found, no other sensor is.
  void note_origin(const wire::Origin& origin);
  // The key that requests are signed with now; nullptr: none is known of this sensor.
  const wire::Key* key() const {
    return at_ < 0 ? nullptr : &keys_.all()[static_cast<std::size_t>(at_)];
  }
  // The sensor refused the key; the next one counts. false: there is no other.
  bool drop_key();
  // The same, but behind the oldest the newest counts again: whoever refused it proved nothing.
  void try_next_key();
  // A renewal by another program of the user: keys that are here get the secrets that they have
  // there. None comes or goes.
  void take_renewed(const wire::KeyTable& keys);
  // The sensor has taken counters up to there.
  void note_highest(std::uint64_t highest);
  // There is no higher counter: this key signs nothing more in this session.
  bool is_used_up() const { return counter_ == std::numeric_limits<std::uint64_t>::max(); }
  std::uint32_t device_id() const { return origin_.device_id; }  // 0: nobody has answered
  std::uint32_t session_id() const { return origin_.session_id; }

  // Only where there is a key. A part of `buffer`.
  std::span<const std::byte> seal(const wire::SettingsRequest& request, std::string_view text,
                                  wire::DatagramBuffer& buffer);
  // kSubscribe or kUnsubscribe.
  std::span<const std::byte> seal(wire::PacketType type, const wire::Subscribe& request,
                                  wire::DatagramBuffer& buffer);
  // The answer to one of the newest requests that were sealed: on a slow network more than one is
  // on its way. None: it is not, or nobody knows of whom.
  std::optional<Answer> open(const wire::PacketView& packet,
                             std::span<const std::byte> datagram) const;
  // The stream key that such an answer hands over, whose origin was noted; number 0: none, or its
  // tags are not known here.
  wire::StreamKey open_stream_key(const Answer& answer) const;
  // How the tags of the stream key that it hands over are made; nothing: it hands over none.
  static std::optional<std::uint8_t> tags_of(const Answer& answer);

 private:
  int last_key_before(int end) const;
  std::span<const std::byte> seal(wire::PacketType type, std::size_t payload_bytes,
                                  wire::DatagramBuffer& buffer);

  wire::KeyTable keys_;
  wire::Origin origin_{};  // device 0: nobody has answered
  int at_ = -1;            // of the key, in keys_; -1: none
  std::uint64_t counter_ = 0;
  struct Sealed {
    std::uint32_t session = 0;
    std::uint64_t counter = 0;  // 0: none
    bool operator==(const Sealed&) const = default;
  };
  // The newest first. Whoever says that there is another session forgets none of them.
  std::array<Sealed, kAnswerable> sealed_{};
  wire::PacketType answer_{};  // that belongs to what was sealed last
};

}  // namespace stof::client
