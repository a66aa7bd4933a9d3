#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/base/status.h"
#include "firmware/wire/keys/key_table.h"
#include "firmware/wire/messages/enums.h"
#include "firmware/wire/packet.h"
#include "host/client/control/control_transport.h"
#include "host/client/control/request_signer.h"
#include "host/client/error.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// Which answers without a signature are believed where they are not only read.
enum class Unsigned : std::uint8_t {
  // Where no key could have signed: there are no keys at all, or none of the sensor that
  // ControlOptions::device_id names. Else whoever claims to be another sensor would be believed.
  kWithoutKeys,
  kNever,
  kAlways,  // over a cable
};

struct ControlOptions {
  Duration timeout = std::chrono::milliseconds(300);  // of one attempt; the last waits for all
  int attempts = 3;                                   // of each request
  // Of request() with all parts of a document and all repetitions, whatever is answered.
  Duration overall = std::chrono::seconds(10);
  std::optional<std::uint32_t> device_id{};  // refuse any other sensor
  wire::KeyTable keys{};  // of sensors; requests to one of them are signed with its key
  Unsigned unsigned_answers = Unsigned::kWithoutKeys;
  bool signed_alone = false;  // documents, too, are read with a key and believed signed alone
  std::string doubt{};  // Meant::doubt: not empty: documents are read, and nothing else is asked
};

struct ControlAnswer {
  // Never kCookie or kStale. kUnknownKey: the sensor has none of the keys, and nothing was changed;
  // by Reach::kLink, where anybody may say so, `text` says what that proves.
  wire::SettingsResult result = wire::SettingsResult::kOk;
  // Of get: the whole document, as the sensor gave it: any bytes, for a terminal see printable.h.
  // Else one line that can be printed: of a refusal which field, and what it takes.
  std::string text;
  std::uint32_t revision = 0;  // of the active settings
  bool restart = false;        // some of the active settings wait for the next start
};

// Asks one sensor to read or change settings; blocks until it is answered. For one thread.
// With a key of the sensor requests are signed, and only answers that it signed too are believed;
// where the sensor has none of the keys (any more), documents are read without (but where they are
// believed signed alone), and nothing is changed but as ControlOptions::unsigned_answers says.
class ControlClient {
 public:
  static constexpr std::size_t kMaxText = 1024;  // of a request, bytes

  explicit ControlClient(std::unique_ptr<ControlTransport> transport,
                         const ControlOptions& options = {});
  static std::expected<ControlClient, ControlError> open(std::string_view sensor,
                                                         const ControlOptions& options = {});

  // Any result is an answer, also a refusal. `document` is used by get only, `text` by the others.
  // get collects a document of any length, and starts again if it changes meanwhile. A request may
  // be served twice after a lost answer: repeating set, stage, commit, save, revert or reset has no
  // further effect. kTimeout: no answer, or not all of it in time; kTooLarge: text above kMaxText;
  // kCorrupt: the answer contradicts itself; kDeviceLost: open again; kUnsupported: nothing proves
  // who answers, it is another sensor, nobody knows which one is meant, or the key has no counters
  // left until the sensor starts again.
  std::expected<ControlAnswer, ControlError> request(wire::SettingsOperation operation,
                                                     wire::SettingsDocument document,
                                                     std::string_view text);

  // The same for an operation whose texts are bytes (upload): request() without making the
  // answer's text printable.
  std::expected<ControlAnswer, ControlError> exchange(wire::SettingsOperation operation,
                                                      std::string_view bytes);

  // The sensor that has signed an answer, and with which key; none: none has.
  struct Proof {
    std::uint32_t device = 0;
    std::uint32_t key_id = 0;
    std::string from{};  // of the newest of these answers, as ControlTransport::from()
  };
  const std::optional<Proof>& proven() const { return proven_; }

 private:
  struct Part;
  // What came upon a request. kAgain: with a cookie, a counter or a key that is known now.
  enum class Heard : std::uint8_t { kNothing, kAgain, kKeyRefused, kBusy, kAnswer };
  std::expected<Part, ControlError> ask(wire::SettingsOperation operation,
                                        wire::SettingsDocument document, std::uint16_t offset,
                                        std::string_view text);
  std::optional<std::expected<Part, ControlError>> ended(wire::SettingsOperation operation,
                                                         bool sealed) const;
  std::expected<std::optional<Part>, ControlError> await(std::uint32_t request_id, bool sealed,
                                                         Duration patience);
  std::optional<Part> read_answer(std::span<const std::byte> datagram, std::uint32_t request_id,
                                  bool sealed);
  std::expected<ControlAnswer, ControlError> get(wire::SettingsOperation operation,
                                                 wire::SettingsDocument document);
  std::span<const std::byte> seal(const wire::SettingsRequest& request, std::string_view text,
                                  wire::DatagramBuffer& buffer) const;
  Status send(const wire::SettingsRequest& request, std::string_view text, bool sealed);
  Heard judge(const std::optional<Part>& part, bool sealed) const;
  std::optional<ControlError> doubtful(wire::SettingsOperation operation) const;
  bool takes_unsigned(wire::SettingsOperation operation) const;
  ControlError unproven() const;
  ControlError silent() const;
  Part keys_unknown() const;
  std::optional<ControlError> another_sensor();
  ControlError used_up() const;
  ControlError error(Status status, std::string_view what) const;

  std::unique_ptr<ControlTransport> transport_;
  ControlOptions options_;
  RequestSigner signer_;
  std::optional<std::vector<std::byte>> kept_;  // came, and was not read yet
  bool keys_refused_ = false;                   // the sensor has none of those that there are of it
  std::optional<Proof> proven_;
  std::uint64_t cookie_ = 0;
  OfferedCookies offered_;   // to what was signed, but by a line
  std::uint64_t shown_ = 0;  // cookie of the newest attempt
  int cookies_refused_ = 0;  // of the request that is asked now
  std::uint32_t request_id_;
  Time deadline_;  // of the request that is asked now
};

}  // namespace stof::client
