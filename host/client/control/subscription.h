#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "firmware/wire/messages/subscribed.h"
#include "firmware/wire/packet.h"
#include "host/client/control/request_signer.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// One line, without its end: a sensor signs streams with such tags, which this release does not
// know, and what to do.
std::string other_tags_text(std::uint8_t tags);

struct SubscriptionOptions {
  // Asked of the sensor, which takes 500 ms to 10 s and says what it grants.
  std::chrono::milliseconds lease{3000};
  // Subscribe at no other device; without it, at whichever answers.
  std::optional<std::uint32_t> device_id{};
  // Raw pictures to ask for, see "Raw pictures" of docs/WIRE.md; without any: none.
  wire::RawRequest raw{};
  // Subscribe only with one of the keys, to streams that are signed for this receiver alone.
  bool signed_streams = false;
  wire::KeyTable keys{};
  // The user's keys as they are now, asked for where the sensor knows none of these, at most once a
  // second: another program may have renewed one. None: they cannot be read. May be empty.
  std::function<std::optional<wire::KeyTable>()> reread{};
};

// Decides what to send to one sensor, and when, so that its streams keep coming: asks every
// 200 ms until it is answered, shows the cookie it is given, asks again after a third of the lease,
// once a second while the sensor is full, and anew when nothing was heard for half a second, as
// after a restart of the sensor. No clock and no socket: `now` is the caller's, and must not go
// back.
class Subscription {
 public:
  static constexpr Duration kRepeat = std::chrono::milliseconds(200);
  static constexpr Duration kSilence = std::chrono::milliseconds(500);
  static constexpr Duration kFullRepeat = std::chrono::seconds(1);

  enum class State : std::uint8_t {
    kAsking,  // no answer yet, or no longer
    kActive,
    kFull,       // the sensor has as many subscribers as it takes
    kNoKey,      // of signed streams: there is no key of the sensor, or it has none of them
    kOtherTags,  // of signed streams: the sensor signs them as no receiver of this release verifies
  };

  // first_request: of the numbers of requests, best random.
  Subscription(const SubscriptionOptions& options, std::uint32_t first_request);

  // The datagram to send now, valid until the next call; empty: none. Call it at next_due(), and
  // again after every take() that returned true.
  std::span<const std::byte> due(Time now);
  // The past: at once.
  Time next_due() const;

  // A datagram from the sensor. True: it was an answer for us, and nobody else's business. A
  // request is answered once: what repeats an answer, or is older than one that came, changes
  // nothing.
  bool take(std::span<const std::byte> datagram, Time now);
  // Anything came from the sensor.
  void heard(Time now) { heard_ = now; }

  // The datagram that ends the subscription; empty: nothing is known to be subscribed. Best sent
  // twice: nobody waits for the answer, and without it the lease runs out.
  std::span<const std::byte> farewell();

  State state() const noexcept { return state_; }
  // Why the newest answer that was no cookie brings no raw pictures: kRawDenied, kRawTaken. kOk: it
  // does, or none were asked for.
  wire::SubscribeResult raw_refusal() const noexcept { return raw_refusal_; }
  // How a sensor signs, in State::kOtherTags (StreamKeyFields::tags).
  std::uint8_t other_tags() const noexcept { return other_tags_; }
  // Who answers in the place of SubscriptionOptions::device_id; none: nobody, or that one.
  std::optional<std::uint32_t> other_sensor() const noexcept { return other_sensor_; }
  // With which key of the user it was proven whose streams they are; 0: it was not.
  std::uint32_t proven_key() const noexcept { return proven_key_; }
  bool signs() const noexcept { return signer_.has_value(); }
  // Of signed streams: what they are signed with; number 0: not known yet.
  const wire::StreamKey& stream_key() const noexcept { return stream_key_; }
  std::uint32_t session() const noexcept { return signer_ ? signer_->session_id() : 0; }
  // Who answered the newest request that was answered: nobody else sends what was asked for. None:
  // nobody did.
  const std::optional<wire::Origin>& answerer() const noexcept { return answerer_; }
  // Something came in the name of another start of the sensor: asks it which one goes on.
  void doubt(Time now);
  // The shortest time from a request to its answer, as this program saw it: an answer's way back
  // takes no longer. None: no request was answered yet.
  std::optional<Duration> round_trip() const noexcept { return round_trip_; }
  // The newest request was not answered yet: the sensor may sign with a key that is on its way.
  bool awaits_answer() const noexcept { return request_ != answered_; }
  // Asks at once that what comes from now on is signed with a new key; at most once a second.
  void renew_key(Time now);
  // When the newest key was asked for: whatever it signs was sent after that.
  Time key_asked() const noexcept { return key_asked_; }

 private:
  static constexpr std::uint32_t kAnswerable = RequestSigner::kAnswerable;

  std::span<const std::byte> seal(wire::PacketType type);
  void answered(const wire::Subscribed& answer, Time now);
  // Whether an answer is believed; of signed streams also what it says of keys.
  bool judge(const wire::PacketView& packet, std::span<const std::byte> datagram,
             std::optional<wire::Subscribed>& answer);
  void judge_tags(const RequestSigner::Answer& answer);
  void reread_keys(Time now);
  void hurry(Time now);
  // When one of the newest requests was sent.
  Time& asked(std::uint32_t request) { return asked_[request % kAnswerable]; }

  SubscriptionOptions options_;
  std::uint32_t request_;   // of the newest request
  std::uint32_t answered_;  // of the newest that was answered
  std::uint64_t cookie_ = 0;
  State state_ = State::kAsking;
  wire::SubscribeResult raw_refusal_ = wire::SubscribeResult::kOk;
  Time next_ = Time::min();
  Time heard_ = Time::min();
  bool hurried_ = false;  // the newest request was sent at once upon a cookie
  std::optional<std::uint32_t> other_sensor_;
  std::optional<RequestSigner> signer_;
  wire::StreamKey stream_key_;
  bool wants_key_ = false;  // another one than that
  std::uint8_t other_tags_ = wire::kStreamTags;
  std::optional<Time> renewed_;
  std::optional<Time> reread_;
  std::array<Time, kAnswerable> asked_{};
  std::optional<Duration> round_trip_;
  Time key_asked_ = Time::min();
  std::uint32_t proven_key_ = 0;
  std::optional<wire::Origin> answerer_;
  wire::DatagramBuffer buffer_{};
};

}  // namespace stof::client
