#include "host/client/control/pair_client.h"

#include <algorithm>
#include <random>
#include <thread>
#include <utility>

#include "firmware/wire/bytes.h"

namespace stof::client {
namespace {

using wire::PairMethod;
using wire::PairResult;
using wire::PairStep;

constexpr Duration kPoll = std::chrono::milliseconds(200);

constexpr std::string_view kNothing = ": nothing was paired";

constexpr std::string_view wrong_text(PairMethod method) noexcept {
  switch (method) {
    case PairMethod::kCode:
      return "has another code, or somebody is between you";
    case PairMethod::kDigits:
      return "somebody is between you, its button was pressed (a hold of less than 3 seconds is a "
             "press), or it took too long";
    default:
      return "somebody is between you, or it took too long";
  }
}

// How far an answer goes: of several to one request the furthest counts.
int rank(PairResult result) noexcept {
  switch (result) {
    case PairResult::kWaiting:
    case PairResult::kOk:
      return 2;
    case PairResult::kCookie:
      return 0;
    default:
      return 1;
  }
}

}  // namespace

PairClient::PairClient(std::unique_ptr<ControlTransport> transport, PairWish wish,
                       ControlOptions options)
    : transport_(std::move(transport)),
      wish_(std::move(wish)),
      options_(std::move(options)),
      request_id_(std::random_device()()) {
  said_.method = wish_.method;
  said_.role = wish_.role;
  said_.name = wire::key_name(wish_.name);
  said_.client_key = exchange_.public_key();
  wire::fill_random(said_.client_nonce);
}

PairClient::~PairClient() {
  if (ended_) {
    return;
  }
  if (opened_) {
    wire::PairRequest refusal = request(PairStep::kAccept);
    wire::put_u32(std::as_writable_bytes(std::span(refusal.value)).first<4>(), wire::kDigitsEnd);
    give_up(refusal);
  } else if (attempt_ != 0) {
    give_up(request(PairStep::kConfirm));  // its tag is none
  }
}

// Twice, for one may be lost; no answer is awaited.
void PairClient::give_up(wire::PairRequest request) {
  for (int i = 0; i < 2; ++i) {
    static_cast<void>(send(request));
  }
  ended_ = true;
}

std::expected<void, ControlError> PairClient::start() {
  wire::PairRequest begin = request(PairStep::kBegin);
  wire::put_bytes(wire::commitment_of(said_.client_key, said_.client_nonce), begin.value);
  const auto begun = ask(begin);
  if (!begun) {
    return std::unexpected(begun.error());
  }
  if (begun->result != PairResult::kOk) {
    return refuse(begun->result);
  }
  attempt_ = begun->attempt;
  said_.sensor = *heard_;
  said_.key_id = begun->key_id;
  said_.sensor_key = wire::bytes_in<wire::PublicKey>(begun->value);
  said_.sensor_nonce = wire::bytes_in<wire::PairNonce>(begun->nonce);
  const std::optional<wire::Secret> shared = exchange_.shared_with(said_.sensor_key);
  if (!shared) {
    return refuse(PairResult::kWrong);
  }
  secrets_.emplace(said_, *shared, wish_.known);
  wire::PairRequest reveal = request(PairStep::kReveal);
  wire::put_bytes(said_.client_key, reveal.value);
  wire::put_bytes(said_.client_nonce, reveal.nonce);
  const auto revealed = ask(reveal);
  if (!revealed) {
    return std::unexpected(revealed.error());
  }
  if (revealed->result != PairResult::kOk ||
      !wire::equal_secrets(wire::bytes_in<wire::Tag>(revealed->value), secrets_->sensor_tag())) {
    return refuse(revealed->result == PairResult::kOk ? PairResult::kWrong : revealed->result);
  }
  return {};
}

std::expected<wire::Key, ControlError> PairClient::finish(Duration patience,
                                                          const std::function<bool()>& goes_on) {
  wire::PairRequest confirm = request(PairStep::kConfirm);
  wire::put_bytes(secrets_->client_tag(), confirm.value);
  const Time deadline = Time::clock::now() + patience;
  for (;;) {
    const auto answer = transport_->reach() == Reach::kLine ? ask(confirm) : ask_overheard(confirm);
    if (!answer) {
      return unproven(answer.error());
    }
    if (is_done(*answer)) {
      ended_ = true;
      return key();
    }
    if (answer->result != PairResult::kWaiting && answer->result != PairResult::kOk) {
      return refuse_confirmed(answer->result);
    }
    const bool late = Time::clock::now() >= deadline;
    if (late || (goes_on && !goes_on())) {
      give_up(request(PairStep::kConfirm));
      return error(Status::kTimeout, late ? "nobody has accepted the digits there"
                                          : "was given up here before anybody accepted it there");
    }
    std::this_thread::sleep_for(kPoll);
  }
}

bool PairClient::is_done(const wire::PairAnswer& answer) const {
  return answer.result == PairResult::kOk &&
         wire::equal_secrets(wire::bytes_in<wire::Tag>(answer.value), secrets_->done_tag());
}

// What refuses a confirm is signed by nobody, and the sensor may have taken it.
std::unexpected<ControlError> PairClient::refuse_confirmed(PairResult why) const {
  if (transport_->reach() == Reach::kLink) {
    return unproven(why == PairResult::kWrong
                        ? error(Status::kCorrupt, wrong_text(wish_.method)).error()
                        : refuse(why).error());
  }
  if (why != PairResult::kWrong) {
    return refuse(why);
  }
  return error(Status::kCorrupt, std::string(wrong_text(wish_.method)) + std::string(kNothing) +
                                     ", unless somebody made this answer up (stof unpair --list "
                                     "tells)");
}

std::unexpected<ControlError> PairClient::unproven(ControlError why) const {
  why.message += wish_.method == PairMethod::kKey
                     ? ": whether it has taken the new secret nobody has proven: try again with "
                       "--renew"
                     : ": a key may have been made: stof unpair --list tells";
  return std::unexpected(std::move(why));
}

std::expected<PairWindow, ControlError> PairClient::open_window() {
  wire::PairRequest open = request(PairStep::kOpen);
  wire::put_bytes(said_.client_nonce, open.nonce);
  const auto window = ask_window(open);
  if (!window && window.error().status == Status::kTimeout && !opened_) {
    return error(Status::kTimeout,
                 "no answer: check the line and its speed; one that is marked serial.remote opens "
                 "nothing");
  }
  opened_ = opened_ || window.has_value();
  return window;
}

std::expected<PairWindow, ControlError> PairClient::accept(std::uint32_t digits) {
  wire::PairRequest accept = request(PairStep::kAccept);
  wire::put_u32(std::as_writable_bytes(std::span(accept.value)).first<4>(), digits);
  return ask_window(accept);
}

std::expected<PairWindow, ControlError> PairClient::ask_window(const wire::PairRequest& request) {
  const auto answer = ask(request);
  if (!answer) {
    return std::unexpected(answer.error());
  }
  switch (answer->result) {
    case PairResult::kOk:
      ended_ = answer->key_id != 0;
      return PairWindow{.key_id = answer->key_id};
    case PairResult::kWaiting:
      return PairWindow{.offer = wire::offer_in(answer->value)};
    case PairResult::kWrong:
      if (request.step == PairStep::kOpen) {
        return error(Status::kUnsupported,
                     "is older than this program: update it, press its button, or pair with the "
                     "cable alone");
      }
      return refuse(answer->result);
    case PairResult::kClosed:
      ended_ = true;
      return error(opened_ ? Status::kTimeout : Status::kUnsupported,
                   opened_ ? "pairing has ended without a key: two came, or nobody in two minutes"
                           : "this line is a way for strangers: use another");
    default:
      return refuse(answer->result);
  }
}

wire::Key PairClient::key() const {
  return {.id = said_.key_id,
          .device = said_.sensor.device_id,
          .role = said_.role,
          .name = said_.name,
          .secret = secrets_->secret()};
}

wire::PairRequest PairClient::request(PairStep step) const {
  wire::PairRequest request{.step = step,
                            .method = wish_.method,
                            .role = wish_.role,
                            .attempt = attempt_,
                            .key_id = wish_.key_id};
  std::ranges::copy(said_.name, request.name.begin());
  return request;
}

// Repeated where an answer gets lost: the sensor serves a step a second time as the first.
std::expected<wire::PairAnswer, ControlError> PairClient::ask(wire::PairRequest request) {
  bool hurried = false;  // asked at once upon a cookie
  bool refused = false;  // a cookie was
  for (int attempt = 0; attempt < options_.attempts;) {
    if (const Status sent = send(request); sent == Status::kDeviceLost) {
      return error(sent, "the connection failed: open it again");
    }
    const std::optional<wire::PairAnswer> answer = await_consent();
    refused = answer && cookie_ != 0;
    cookie_ = answer ? answer->cookie : cookie_;
    if (answer && answer->result != PairResult::kCookie) {
      return *answer;
    }
    attempt += answer && !hurried ? 0 : 1;
    hurried = answer.has_value();
  }
  return refused ? error(Status::kTimeout,
                         "asks for another cookie whatever it is shown: somebody answers in its "
                         "place, or it has just started: try again")
                 : no_answer();
}

// By address whoever is before the sensor may refuse what it grants.
std::optional<wire::PairAnswer> PairClient::await_consent() {
  const auto refuses = [](const wire::PairAnswer& answer) {
    return answer.result != PairResult::kOk && answer.result != PairResult::kCookie &&
           answer.result != PairResult::kWaiting;
  };
  const Time deadline = Time::clock::now() + options_.timeout;
  std::optional<wire::PairAnswer> first = await(request_id_, deadline);
  if (!first || transport_->reach() != Reach::kAddress || !refuses(*first)) {
    return first;
  }
  const Time behind = std::min(deadline, Time::clock::now() + kBehindARefusal);
  while (const std::optional<wire::PairAnswer> other = await(request_id_, behind)) {
    if (!refuses(*other)) {
      return other;
    }
  }
  return first;
}

// Whoever hears the request may refuse it, before the sensor or after: only the time ends it, by
// broadcast, where all of a link hear it, that of all attempts.
std::expected<wire::PairAnswer, ControlError> PairClient::ask_overheard(wire::PairRequest request) {
  const bool by_address = transport_->reach() == Reach::kAddress;
  std::optional<wire::PairAnswer> furthest;
  OfferedCookies offered;
  for (int attempt = 0; attempt < options_.attempts; ++attempt) {
    if (const Status sent = send(request); sent == Status::kDeviceLost) {
      return error(sent, "the connection failed: open it again");
    }
    Time deadline = Time::clock::now() + options_.timeout;
    while (const std::optional<wire::PairAnswer> answer = await(request_id_, deadline)) {
      if (by_address) {
        deadline = std::min(deadline, Time::clock::now() + kBehindARefusal);
      }
      if (is_done(*answer)) {
        return *answer;
      }
      if (answer->result == PairResult::kCookie) {
        offered.add(answer->cookie);
      }
      if (!furthest || rank(answer->result) > rank(furthest->result)) {
        furthest = answer;
      }
    }
    if (furthest && (furthest->result == PairResult::kWaiting ||
                     (by_address && furthest->result != PairResult::kCookie))) {
      break;
    }
    cookie_ = offered.take().value_or(cookie_);
  }
  if (!furthest || furthest->result == PairResult::kCookie) {
    return no_answer();
  }
  return *furthest;
}

std::unexpected<ControlError> PairClient::no_answer() const {
  return error(Status::kTimeout, std::string("no answer: ") + to_check(transport_->reach()));
}

Status PairClient::send(wire::PairRequest& request) {
  request.request_id = ++request_id_;
  request.cookie = cookie_;
  if (request.step == PairStep::kBegin && !wish_.known.empty()) {
    wire::put_bytes(wire::begin_proof(wish_.known, request), request.nonce);
  }
  wire::DatagramBuffer buffer;
  wire::encode_pair_request(request, wire::payload_space(buffer).first<wire::kPairRequestBytes>());
  return transport_->send(
      wire::seal_packet({.type = wire::PacketType::kPairRequest,
                         .origin = {.device_id = options_.device_id.value_or(0)}},
                        wire::kPairRequestBytes, buffer));
}

std::optional<wire::PairAnswer> PairClient::await(std::uint32_t request_id, Time deadline) {
  for (int behind = 0;;) {
    const Result<std::vector<std::byte>> bytes = receive_until(*transport_, deadline, behind);
    if (!bytes && (bytes.error() == Status::kTimeout || bytes.error() == Status::kDeviceLost)) {
      return std::nullopt;
    }
    const auto packet =
        bytes ? wire::parse_packet(*bytes) : std::unexpected(wire::PacketFault::kTruncated);
    if (!packet || packet->header.type != wire::PacketType::kPairAnswer ||
        (options_.device_id && packet->header.origin.device_id != *options_.device_id)) {
      continue;
    }
    const Result<wire::PairAnswer> answer = wire::decode_pair_answer(packet->payload);
    // To an attempt of before: a sensor takes each cookie that it offers.
    const bool late = answer && cookie_ != 0 && answer->result == PairResult::kCookie &&
                      answer->cookie == cookie_;
    if (answer && answer->request_id == request_id && !late) {
      heard_ = packet->header.origin;
      return *answer;
    }
  }
  return std::nullopt;
}

std::unexpected<ControlError> PairClient::refuse(PairResult why) const {
  switch (why) {
    case PairResult::kClosed:
      switch (wish_.method) {
        case PairMethod::kDigits:
          return error(Status::kUnsupported,
                       "does not pair now: press its button, or ask over its cable (stof pair "
                       "--serial LINE --window), and try again within two minutes");
        case PairMethod::kCode:
          return error(Status::kUnsupported, "has no code: pair with its button or its cable");
        case PairMethod::kCable:
          return error(Status::kUnsupported, "this line is a way for strangers: use another");
        case PairMethod::kKey:
          return error(Status::kUnsupported, "has none of your keys: pair with it (stof pair)");
      }
      break;
    case PairResult::kBusy:
      return error(Status::kWouldBlock,
                   wish_.method == PairMethod::kDigits
                       ? "somebody else pairs at the same time, both have ended: press its button "
                         "until it says that pairing is open"
                       : "somebody else pairs now: try again in ten seconds");
    case PairResult::kFull:
      return error(Status::kTooLarge,
                   "keeps no more keys, or cannot save them: unpair a key (stof unpair)");
    case PairResult::kLater:
      return error(Status::kWouldBlock,
                   wish_.method == PairMethod::kKey
                       ? "this key was renewed ten times, it spares its flash: once an hour from "
                         "now on; where that was somebody else, end the key (stof unpair)"
                       : "its code made ten keys, it spares its flash: once an hour from now on; "
                         "its button and its cable pair at any time");
    case PairResult::kWrong:
      return error(Status::kCorrupt, std::string(wrong_text(wish_.method)) + std::string(kNothing));
    default:
      break;
  }
  return error(Status::kCorrupt,
               "its answer contradicts itself: where nobody else answers in its name, update this "
               "program or the sensor");
}

std::unexpected<ControlError> PairClient::error(Status status, std::string_view what) const {
  std::string message = "sensor " + transport_->place() + ": ";
  return std::unexpected(ControlError{.status = status, .message = message.append(what)});
}

}  // namespace stof::client
