#include "host/client/control/control_client.h"

#include <algorithm>
#include <random>
#include <span>
#include <thread>
#include <utility>

#include "firmware/wire/messages/settings_answer.h"
#include "firmware/wire/messages/settings_request.h"
#include "host/client/control/known_sensors.h"
#include "host/client/printable.h"

namespace stof::client {
namespace {

constexpr Duration kBusyPause = std::chrono::milliseconds(50);

// What everybody may read.
bool only_reads(wire::SettingsOperation operation) {
  return operation == wire::SettingsOperation::kGet ||
         operation == wire::SettingsOperation::kDownload;
}

}  // namespace

struct ControlClient::Part {
  wire::SettingsAnswer answer;
  std::string text;
  bool is_signed = false;
};

ControlClient::ControlClient(std::unique_ptr<ControlTransport> transport,
                             const ControlOptions& options)
    : transport_(std::move(transport)),
      options_(options),
      signer_(options.keys),
      request_id_(std::random_device()()) {}

std::expected<ControlClient, ControlError> ControlClient::open(std::string_view sensor,
                                                               const ControlOptions& options) {
  auto transport = open_udp_transport(sensor);
  if (!transport) {
    return std::unexpected(std::move(transport.error()));
  }
  return ControlClient(std::move(*transport), options);
}

std::expected<ControlAnswer, ControlError> ControlClient::request(wire::SettingsOperation operation,
                                                                  wire::SettingsDocument document,
                                                                  std::string_view text) {
  if (operation == wire::SettingsOperation::kGet || operation == wire::SettingsOperation::kKeys) {
    if (std::optional<ControlError> error = doubtful(operation)) {
      return std::unexpected(*std::move(error));
    }
    deadline_ = Time::clock::now() + options_.overall;
    return get(operation, document);
  }
  std::expected<ControlAnswer, ControlError> answer = exchange(operation, text);
  if (answer) {
    answer->text = printable(answer->text);
  }
  return answer;
}

// Nobody knows which sensor is meant.
std::optional<ControlError> ControlClient::doubtful(wire::SettingsOperation operation) const {
  if (options_.doubt.empty() || only_reads(operation)) {
    return std::nullopt;
  }
  return error(Status::kUnsupported, options_.doubt + " (--device NUMBER or --key ID)");
}

std::expected<ControlAnswer, ControlError> ControlClient::exchange(
    wire::SettingsOperation operation, std::string_view bytes) {
  if (std::optional<ControlError> error = doubtful(operation)) {
    return std::unexpected(*std::move(error));
  }
  deadline_ = Time::clock::now() + options_.overall;
  if (bytes.size() > kMaxText) {
    return std::unexpected(error(Status::kTooLarge, "a request takes " + std::to_string(kMaxText) +
                                                        " bytes: send several smaller ones"));
  }
  std::expected<Part, ControlError> part = ask(operation, {}, 0, bytes);
  if (!part) {
    return std::unexpected(std::move(part.error()));
  }
  return ControlAnswer{.result = part->answer.result,
                       .text = std::move(part->text),
                       .revision = part->answer.revision,
                       .restart = part->answer.restart != 0};
}

std::expected<ControlAnswer, ControlError> ControlClient::get(wire::SettingsOperation operation,
                                                              wire::SettingsDocument document) {
  constexpr int kTries = 3;
  for (int i = 0; i < kTries; ++i) {
    std::string text;
    std::optional<wire::SettingsAnswer> first;
    for (;;) {
      std::expected<Part, ControlError> part =
          ask(operation, document, static_cast<std::uint16_t>(text.size()), {});
      if (!part) {
        return std::unexpected(std::move(part.error()));
      }
      const wire::SettingsAnswer answer = part->answer;
      if (answer.result != wire::SettingsResult::kOk) {
        return ControlAnswer{.result = answer.result,
                             .text = printable(part->text),
                             .revision = answer.revision,
                             .restart = answer.restart != 0};
      }
      first = first.value_or(answer);
      if (answer.total != first->total || answer.revision != first->revision) {
        break;  // it changed: again from the beginning
      }
      text += part->text;
      if (text.size() == answer.total) {
        return ControlAnswer{.result = answer.result,
                             .text = std::move(text),
                             .revision = answer.revision,
                             .restart = answer.restart != 0};
      }
      if (part->text.empty() || text.size() > answer.total) {
        return std::unexpected(error(Status::kCorrupt,
                                     "its answer contradicts itself: where nobody else answers in "
                                     "its name, update this program or the sensor"));
      }
    }
  }
  return std::unexpected(
      error(Status::kTimeout, "its settings changed while they were read: try again"));
}

// What ends a request before it is sent once more.
std::optional<std::expected<ControlClient::Part, ControlError>> ControlClient::ended(
    wire::SettingsOperation operation, bool sealed) const {
  using Ended = std::expected<Part, ControlError>;
  if (Time::clock::now() >= deadline_) {
    return Ended(std::unexpected(error(Status::kTimeout, "its answer takes too long: try again")));
  }
  if (keys_refused_ && options_.signed_alone) {
    return Ended(std::unexpected(
        error(Status::kUnsupported,
              "has none of your keys, it says: pair with it, see stof pair --help")));
  }
  if (keys_refused_ && !only_reads(operation)) {
    return Ended(keys_unknown());
  }
  if (!sealed && cookie_ != 0 && !takes_unsigned(operation)) {
    return Ended(std::unexpected(unproven()));
  }
  return std::nullopt;
}

// Asks until it is answered, with a cookie where the sensor wants one.
std::expected<ControlClient::Part, ControlError> ControlClient::ask(
    wire::SettingsOperation operation, wire::SettingsDocument document, std::uint16_t offset,
    std::string_view text) {
  ++request_id_;
  cookies_refused_ = 0;
  offered_.clear();
  std::optional<Part> refusal;
  bool hurried = false;  // asked at once upon a cookie
  bool introduced = false;
  for (int attempt = 0; attempt < options_.attempts;) {
    const bool sealed = signer_.key() != nullptr;
    if (std::optional<std::expected<Part, ControlError>> end = ended(operation, sealed)) {
      return *std::move(end);
    }
    const Status sent = send({.request_id = request_id_,
                              .operation = operation,
                              .document = document,
                              .offset = offset,
                              .cookie = cookie_},
                             text, sealed);
    if (sent == Status::kDeviceLost) {
      return std::unexpected(error(sent, "the connection failed: open it again"));
    }
    // Answers to the attempts of before count, too: on a slow network the last one waits for them.
    const bool last = attempt + 1 == options_.attempts;
    std::expected<std::optional<Part>, ControlError> heard =
        await(request_id_, sealed, last ? options_.timeout * options_.attempts : options_.timeout);
    if (!heard) {
      return std::unexpected(std::move(heard.error()));
    }
    const std::optional<Part>& part = *heard;
    if (part && sealed && signer_.is_used_up()) {
      return std::unexpected(used_up());
    }
    switch (judge(part, sealed)) {
      case Heard::kNothing:
        if (std::optional<ControlError> other = attempt++ == 0 ? another_sensor() : std::nullopt) {
          return std::unexpected(*std::move(other));
        }
        break;
      case Heard::kAgain:
        attempt = introduced ? attempt + (hurried ? 1 : 0) : 0;
        hurried = !hurried;
        introduced = true;
        break;
      case Heard::kKeyRefused:
        keys_refused_ = !signer_.drop_key();
        break;
      case Heard::kBusy:
        refusal = part;
        std::this_thread::sleep_for(kBusyPause);
        ++attempt;
        break;
      case Heard::kAnswer:
        if (!sealed && !takes_unsigned(operation)) {
          return std::unexpected(unproven());
        }
        return *part;
    }
  }
  return refusal ? std::expected<Part, ControlError>(*refusal) : std::unexpected(silent());
}

Status ControlClient::send(const wire::SettingsRequest& request, std::string_view text,
                           bool sealed) {
  wire::DatagramBuffer buffer;
  shown_ = cookie_;
  return transport_->send(sealed ? signer_.seal(request, text, buffer)
                                 : seal(request, text, buffer));
}

ControlClient::Heard ControlClient::judge(const std::optional<Part>& part, bool sealed) const {
  if (!part) {
    return Heard::kNothing;
  }
  switch (part->answer.result) {
    case wire::SettingsResult::kCookie:
    case wire::SettingsResult::kStale:
      return Heard::kAgain;
    case wire::SettingsResult::kBusy:
      return Heard::kBusy;
    default:
      break;
  }
  if (sealed) {
    return part->answer.result == wire::SettingsResult::kUnknownKey ? Heard::kKeyRefused
                                                                    : Heard::kAnswer;
  }
  // Served without a signature, though there is a key.
  return signer_.key() != nullptr && options_.unsigned_answers != Unsigned::kAlways
             ? Heard::kAgain
             : Heard::kAnswer;
}

std::span<const std::byte> ControlClient::seal(const wire::SettingsRequest& request,
                                               std::string_view text,
                                               wire::DatagramBuffer& buffer) const {
  const std::span<std::byte, wire::kMaxPayload> payload = wire::payload_space(buffer);
  wire::encode_settings_request(request, payload.first<wire::kSettingsRequestBytes>());
  std::ranges::copy(std::as_bytes(std::span(text)),
                    payload.subspan<wire::kSettingsRequestBytes>().begin());
  return wire::seal_packet({.type = wire::PacketType::kSettingsRequest,
                            .origin = {.device_id = options_.device_id.value_or(0)}},
                           wire::kSettingsRequestBytes + text.size(), buffer);
}

// The answer to a request, none when the time is over. Anything else that comes is skipped.
std::expected<std::optional<ControlClient::Part>, ControlError> ControlClient::await(
    std::uint32_t request_id, bool sealed, Duration patience) {
  const Time begin = Time::clock::now();
  Time deadline = std::min(begin + patience, std::max(begin, deadline_));
  // Whoever hears the request may refuse it: the sensor's own answer may come behind that.
  const auto proves = [&](const Part& part) {
    return !sealed || part.is_signed || transport_->reach() == Reach::kLine ||
           (transport_->reach() == Reach::kAddress &&
            part.answer.result != wire::SettingsResult::kUnknownKey &&
            part.answer.result != wire::SettingsResult::kCookie);
  };
  std::optional<Part> refusal;
  for (int behind = 0;;) {
    const Result<std::vector<std::byte>> bytes =
        kept_ ? *std::exchange(kept_, std::nullopt) : receive_until(*transport_, deadline, behind);
    if (!bytes && bytes.error() == Status::kTimeout) {
      cookie_ = offered_.take().value_or(cookie_);
      return refusal;
    }
    if (!bytes && bytes.error() == Status::kDeviceLost) {
      return std::unexpected(error(bytes.error(), "the connection failed: open it again"));
    }
    if (!bytes) {
      continue;  // nobody listens yet
    }
    std::optional<Part> part = read_answer(*bytes, request_id, sealed);
    if (part && proves(*part)) {
      offered_.clear();
      return part;
    }
    if (part && !refusal && transport_->reach() == Reach::kAddress) {
      deadline = std::min(deadline, Time::clock::now() + kBehindARefusal);
    }
    if (!refusal) {
      refusal = std::move(part);
    }
  }
}

// None: something else. To a request that was signed an answer without a signature only says that
// it was not judged: it asks for a cookie, or knows no such key.
std::optional<ControlClient::Part> ControlClient::read_answer(std::span<const std::byte> datagram,
                                                              std::uint32_t request_id,
                                                              bool sealed) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet || (options_.device_id && packet->header.origin.device_id != *options_.device_id)) {
    return std::nullopt;
  }
  std::span<const std::byte> payload = packet->payload;
  const std::optional<RequestSigner::Answer> signed_answer = signer_.open(*packet, datagram);
  if (signed_answer) {
    payload = signed_answer->payload;
    proven_ = Proof{.device = packet->header.origin.device_id,
                    .key_id = signer_.key()->id,
                    .from = transport_->from()};
  } else if (packet->header.type != wire::PacketType::kSettingsAnswer) {
    return std::nullopt;
  }
  const Result<wire::SettingsAnswer> answer = wire::decode_settings_answer(payload);
  if (!answer || answer->request_id != request_id) {
    return std::nullopt;
  }
  // To an attempt of before: a sensor takes each cookie that it offers.
  const wire::Origin& from = packet->header.origin;
  const bool known =
      !sealed || (from.device_id == signer_.device_id() && from.session_id == signer_.session_id());
  if (answer->result == wire::SettingsResult::kCookie && shown_ != 0 && answer->cookie == shown_ &&
      known) {
    return std::nullopt;
  }
  const bool judged = answer->result != wire::SettingsResult::kCookie &&
                      answer->result != wire::SettingsResult::kUnknownKey;
  if (sealed && !signed_answer && judged) {
    return std::nullopt;
  }
  if (sealed && !signed_answer && transport_->reach() != Reach::kLine) {
    offered_.add(answer->cookie);
  } else {
    cookie_ = answer->cookie;
  }
  cookies_refused_ += answer->result == wire::SettingsResult::kCookie && shown_ != 0 ? 1 : 0;
  signer_.note_origin(packet->header.origin);
  signer_.note_highest(signed_answer ? signed_answer->highest : 0);
  const std::span<const std::byte> text = payload.subspan(wire::kSettingsAnswerBytes);
  Part part{.answer = *answer,
            .text = std::string(text.size(), '\0'),
            .is_signed = signed_answer.has_value()};
  std::ranges::transform(text, part.text.begin(),
                         [](std::byte byte) { return static_cast<char>(byte); });
  return part;
}

bool ControlClient::takes_unsigned(wire::SettingsOperation operation) const {
  if (options_.signed_alone) {
    return false;
  }
  if (only_reads(operation) || options_.unsigned_answers == Unsigned::kAlways) {
    return true;
  }
  return options_.unsigned_answers == Unsigned::kWithoutKeys &&
         (options_.keys.count() == 0 || options_.device_id);
}

// Another one answers in the place of ControlOptions::device_id, which has never answered: sensors
// leave requests to another one unanswered, so this asks for none.
std::optional<ControlError> ControlClient::another_sensor() {
  constexpr std::uint32_t kProbe = 1U << 31U;  // in the number of a request
  wire::DatagramBuffer buffer;
  wire::encode_settings_request({.request_id = request_id_ ^ kProbe},
                                wire::payload_space(buffer).first<wire::kSettingsRequestBytes>());
  if (!options_.device_id || cookie_ != 0 ||
      transport_->send(wire::seal_packet({.type = wire::PacketType::kSettingsRequest},
                                         wire::kSettingsRequestBytes, buffer)) != Status::kOk) {
    return std::nullopt;
  }
  const Time deadline = Time::clock::now() + options_.timeout;
  for (int behind = 0;;) {
    const Result<std::vector<std::byte>> bytes = receive_until(*transport_, deadline, behind);
    if (!bytes) {
      return std::nullopt;
    }
    const auto packet = wire::parse_packet(*bytes);
    if (!packet || packet->header.type != wire::PacketType::kSettingsAnswer) {
      continue;
    }
    const Result<wire::SettingsAnswer> answer = wire::decode_settings_answer(packet->payload);
    const std::uint32_t device = packet->header.origin.device_id;
    if (!answer || (answer->request_id ^ request_id_) % kProbe != 0) {
      continue;
    }
    if (device != *options_.device_id) {
      return error(Status::kUnsupported, other_sensor(device, *options_.device_id));
    }
    if (answer->request_id == request_id_) {  // it has answered late what it was asked before
      kept_ = *bytes;
    }
    return std::nullopt;
  }
}

ControlError ControlClient::silent() const {
  constexpr int kLate = 1;  // one may have been on its way
  if (cookies_refused_ > kLate) {
    return error(Status::kTimeout,
                 "asks for another cookie whatever it is shown: somebody answers in its place, or "
                 "it has just started: try again");
  }
  const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(options_.timeout);
  return error(Status::kTimeout, "no answer within " +
                                     std::to_string(waited.count() * (2 * options_.attempts - 1)) +
                                     " ms: " + to_check(transport_->reach()) +
                                     "; a slow network takes a longer timeout");
}

ControlClient::Part ControlClient::keys_unknown() const {
  const bool anybody = transport_->reach() == Reach::kLink;
  return Part{.answer = {.result = wire::SettingsResult::kUnknownKey},
              .text = anybody
                          ? "has none of your keys, it says without a signature, as anybody of "
                            "the link can: pair with it (stof pair), or see whether it did what "
                            "was asked (stof config get, stof unpair --list)"
                          : ""};
}

ControlError ControlClient::used_up() const {
  return error(Status::kUnsupported,
               "takes no more of this key until it starts again: somebody used its last counter; "
               "use another key");
}

ControlError ControlClient::unproven() const {
  const std::string number = std::to_string(signer_.device_id());
  if (options_.signed_alone) {
    return error(Status::kUnsupported, "says that it is number " + number +
                                           ", of which you have no key: nothing proves what it "
                                           "tells: pair with it, see stof pair --help");
  }
  return error(Status::kUnsupported,
               options_.unsigned_answers == Unsigned::kNever
                   ? "says that it is number " + number +
                         ", of which you have no key: nothing proves who answers, and nothing was "
                         "changed"
                   : "says that it is number " + number +
                         ", of which you have no key: pair with it, or name it by --device " +
                         number + " where it is none of yours; nothing was changed");
}

ControlError ControlClient::error(Status status, std::string_view what) const {
  std::string message = "sensor " + transport_->place() + ": ";
  return {.status = status, .message = message.append(what)};
}

}  // namespace stof::client
