#include "firmware/control/request_handler.h"

#include <algorithm>

namespace stof::firmware {

using wire::PacketFault;
using wire::PacketType;

RequestHandler::RequestHandler(const wire::Origin& origin, const CookieSecret& secret,
                               LeaseTable& subscribers, SettingsService* settings,
                               keys::Authenticator* authenticator) noexcept
    : origin_(origin),
      cookies_(secret),
      subscribers_(subscribers),
      settings_(settings),
      authenticator_(authenticator),
      limits_(secret) {}

void RequestHandler::set_announce(const wire::Announce& announce, wire::Health health) noexcept {
  announce_ = announce;
  health_ = health;
}

std::span<const std::byte> RequestHandler::take(std::span<const std::byte> datagram,
                                                const hal::Peer& from, hal::Time now) noexcept {
  const std::expected<wire::PacketView, PacketFault> packet = wire::parse_packet(datagram);
  if (!packet) {
    return refuse(reason(packet.error()));
  }
  const wire::Header& header = packet->header;
  if (header.type != PacketType::kSubscribe && header.type != PacketType::kUnsubscribe &&
      header.type != PacketType::kSettingsRequest && header.type != PacketType::kSignedRequest &&
      header.type != PacketType::kPairRequest && header.type != PacketType::kDiscover) {
    return refuse(Count::kNotControl);
  }
  const bool over_link = is_over_link(from);
  const bool for_any =
      header.origin.device_id == 0 && (!over_link || header.type == PacketType::kDiscover);
  if (!for_any && header.origin.device_id != origin_.device_id) {
    return refuse(Count::kForeign);
  }
  if (over_link &&
      (header.type == PacketType::kSubscribe || header.type == PacketType::kUnsubscribe)) {
    return refuse(Count::kNotControl);
  }
  const Request request{.packet = *packet, .from = from, .now = now, .datagram = datagram};
  switch (header.type) {
    case PacketType::kDiscover:
      return discover(request);
    case PacketType::kSettingsRequest:
      return serve_settings(request);
    case PacketType::kSignedRequest:
      return serve_signed(request);
    case PacketType::kPairRequest:
      return pair(request);
    default:
      return subscribe(request);
  }
}

void RequestHandler::drop_ended(hal::Time now) noexcept {
  subscribers_.expire(now);
  if (authenticator_ != nullptr) {
    subscribers_.drop_ended_keys(authenticator_->keys());
  }
}

RequestHandler::Answer RequestHandler::subscribe(const Request& request) noexcept {
  const Result<wire::Subscribe> asked = wire::decode_subscribe(request.packet.payload);
  if (!asked) {
    return refuse(Count::kBadField);
  }
  wire::Subscribed out{.request_id = asked->request_id};
  if (!cookies_.valid(asked->cookie, request.from, request.now)) {
    return subscribe_cookie(request, asked->request_id);
  }
  if (!may_serve(request)) {
    return {};
  }
  count(Count::kAccepted);
  if (request.packet.header.type == PacketType::kUnsubscribe) {
    subscribers_.unsubscribe(request.from);
    out.result = wire::SubscribeResult::kEnded;
    return answer(request, out);
  }
  drop_ended(request.now);
  subscribers_.keep_place(authenticator_ != nullptr && authenticator_->knows_keys());
  const hal::Duration lease = LeaseTable::granted(asked->lease_ms);
  if (subscribers_.subscribe(request.from, lease, request.now)) {
    const bool open =
        authenticator_ != nullptr && authenticator_->unsigned_access() >= Access::kHarmless;
    out.result = subscribers_.ask_raw(request.from, asked->raw, {.unpaired = open});
    out.lease_ms = static_cast<std::uint16_t>(lease / std::chrono::milliseconds(1));
  } else {
    out.result = wire::SubscribeResult::kFull;
  }
  return answer(request, out);
}

RequestHandler::Answer RequestHandler::serve_settings(const Request& request) noexcept {
  const Result<wire::SettingsRequest> asked = wire::decode_settings_request(request.packet.payload);
  if (!asked) {
    return refuse(Count::kBadField);
  }
  if (!cookies_.valid(asked->cookie, request.from, request.now)) {
    return answer_cookie(request, asked->request_id);
  }
  if (!may_serve(request)) {
    return {};
  }
  count(Count::kAccepted);
  const Access access =
      authenticator_ == nullptr ? Access::kRead : authenticator_->unsigned_access();
  return seal(PacketType::kSettingsAnswer,
              serve(*asked, request.packet.payload.subspan(wire::kSettingsRequestBytes), request,
                    access, 0, wire::payload_space(buffer_)));
}

// Whatever is cheap comes first: the cookie, the session, the host's share.
RequestHandler::Answer RequestHandler::serve_signed(const Request& request) noexcept {
  const Result<wire::SignedView> view = wire::open_signed(request.packet, request.datagram);
  std::optional<SignedRequest> asked = view ? read_signed(request, *view) : std::nullopt;
  if (!asked) {
    return refuse(Count::kBadField);
  }
  const bool settings = asked->type == PacketType::kSettingsRequest;
  if (request.packet.header.origin.session_id != origin_.session_id ||
      !cookies_.valid(asked->cookie, request.from, request.now)) {
    return settings ? answer_cookie(request, asked->request_id)
                    : subscribe_cookie(request, asked->request_id);
  }
  if (!may_serve(request)) {
    return {};
  }
  using Verdict = keys::Authenticator::Verdict;
  const keys::Authenticator::Signer signer =
      authenticator_ == nullptr ? keys::Authenticator::Signer{} : authenticator_->judge(*view);
  if (signer.verdict == Verdict::kForged) {
    return unknown_key(*asked);
  }
  const bool replayed = signer.verdict == Verdict::kReplayed;
  count(replayed ? Count::kReplayed : Count::kAccepted);
  if (replayed && !limits_.may_refuse(request.from, request.now)) {
    return {};
  }
  wire::Key key = *signer.key;  // which may be none any more when the answer goes
  if (signer.former) {
    key.secret = *key.former;
  }
  asked->key = &key;
  const std::span<std::byte> payload = wire::signed_space(buffer_);
  std::size_t bytes = 0;
  if (replayed) {
    bytes = serve_stale(*asked, payload);
  } else if (settings) {
    bytes = serve(*wire::decode_settings_request(view->payload),
                  view->payload.subspan(wire::kSettingsRequestBytes), request, access_of(key.role),
                  key.id, payload);
  } else {
    bytes = serve_subscribe(*asked, payload);
  }
  const Answer sealed = wire::seal_signed(
      {.type = PacketType::kSignedAnswer, .origin = origin_, .frame = {.health = health_}},
      {.key_id = key.id,
       .type = static_cast<std::uint8_t>(settings ? PacketType::kSettingsAnswer
                                                  : PacketType::kSubscribed),
       .counter = view->fields.counter,
       .highest = signer.highest},
      bytes, key.secret, buffer_);
  wire::wipe(key.secret);
  if (key.former) {
    wire::wipe(*key.former);
  }
  return sealed;
}

hal::Peer RequestHandler::asker_of(const Request& request) noexcept {
  return is_over_link(request.from) ? all_of_link(request.from.scope) : request.from;
}

std::optional<RequestHandler::SignedRequest> RequestHandler::read_signed(
    const Request& request, const wire::SignedView& view) noexcept {
  SignedRequest read{
      .request = request, .view = view, .type = static_cast<PacketType>(view.fields.type)};
  if (read.type == PacketType::kSettingsRequest) {
    const Result<wire::SettingsRequest> asked = wire::decode_settings_request(view.payload);
    if (!asked) {
      return std::nullopt;
    }
    read.request_id = asked->request_id;
    read.cookie = asked->cookie;
    return read;
  }
  const Result<wire::Subscribe> asked = wire::decode_subscribe(view.payload);
  // A serial line, which has no address, is no receiver of the network: its profile is a setting. A
  // whole link is none, either.
  const bool known =
      (read.type == PacketType::kSubscribe || read.type == PacketType::kUnsubscribe) &&
      request.from != hal::Peer{} && !is_over_link(request.from);
  if (!known || !asked) {
    return std::nullopt;
  }
  read.request_id = asked->request_id;
  read.cookie = asked->cookie;
  return read;
}

std::size_t RequestHandler::serve_subscribe(const SignedRequest& request,
                                            std::span<std::byte> payload) noexcept {
  const wire::Subscribe asked = *wire::decode_subscribe(request.view.payload);
  const hal::Peer& from = request.request.from;
  wire::Subscribed out{.request_id = request.request_id};
  wire::StreamKeyFields handover{};
  drop_ended(request.request.now);
  if (request.type == PacketType::kUnsubscribe) {
    subscribers_.unsubscribe(from, true);
    out.result = wire::SubscribeResult::kEnded;
  } else {
    const hal::Duration lease = LeaseTable::granted(asked.lease_ms);
    const wire::StreamKey* const stream = subscribers_.subscribe_signed(
        from, {.key_id = request.key->id, .has = asked.stream_key}, lease, request.request.now);
    out.result = wire::SubscribeResult::kFull;
    if (stream != nullptr) {
      out.result = subscribers_.ask_raw(from, asked.raw, {.role = request.key->role});
      out.lease_ms = static_cast<std::uint16_t>(lease / std::chrono::milliseconds(1));
      handover = wire::seal_stream_key(
          *stream,
          {.sensor = origin_, .key = *request.key, .counter = request.view.fields.counter});
    }
  }
  put_subscribed(out, request.request, payload);
  wire::encode_stream_key_fields(
      handover, payload.subspan<wire::kSubscribedBytes, wire::kStreamKeyFieldsBytes>());
  return wire::kSubscribedBytes + wire::kStreamKeyFieldsBytes;
}

std::size_t RequestHandler::serve_stale(const SignedRequest& request,
                                        std::span<std::byte> payload) noexcept {
  if (request.type != PacketType::kSettingsRequest) {
    put_subscribed({.request_id = request.request_id, .result = wire::SubscribeResult::kStale},
                   request.request, payload);
    return wire::kSubscribedBytes;
  }
  wire::encode_settings_answer({.request_id = request.request_id,
                                .result = wire::SettingsResult::kStale,
                                .cookie = cookies_.make(request.request.from, request.request.now)},
                               payload.first<wire::kSettingsAnswerBytes>());
  return wire::kSettingsAnswerBytes;
}

RequestHandler::Answer RequestHandler::unknown_key(const SignedRequest& request) noexcept {
  count(Count::kForged);
  if (!limits_.may_refuse(request.request.from, request.request.now)) {
    return {};
  }
  if (request.type != PacketType::kSettingsRequest) {
    return answer(request.request,
                  {.request_id = request.request_id, .result = wire::SubscribeResult::kUnknownKey});
  }
  return answer({.request_id = request.request_id,
                 .result = wire::SettingsResult::kUnknownKey,
                 .cookie = cookies_.make(request.request.from, request.request.now)},
                0);
}

RequestHandler::Answer RequestHandler::pair(const Request& request) noexcept {
  const Result<wire::PairRequest> asked = wire::decode_pair_request(request.packet.payload);
  if (!asked) {
    return refuse(Count::kBadField);
  }
  wire::PairAnswer out{.result = wire::PairResult::kClosed};
  if (!cookies_.valid(asked->cookie, request.from, request.now)) {
    if (!may_answer_unproven(request, wire::kPairAnswerBytes)) {
      return {};
    }
    count(Count::kCookies);
    out.result = wire::PairResult::kCookie;
  } else if (!may_serve(request)) {
    return {};
  } else {
    count(Count::kAccepted);
    if (pairing_ != nullptr) {
      out = pairing_->serve(*asked, keys::PairingWay::kNetwork, request.now, asker_of(request));
    }
  }
  out.request_id = asked->request_id;
  out.cookie = cookies_.make(request.from, request.now);
  wire::encode_pair_answer(out, wire::payload_space(buffer_).first<wire::kPairAnswerBytes>());
  return seal(PacketType::kPairAnswer, wire::kPairAnswerBytes);
}

std::size_t RequestHandler::serve(const wire::SettingsRequest& asked,
                                  std::span<const std::byte> text, const Request& request,
                                  Access access, std::uint32_t key_id,
                                  std::span<std::byte> payload) noexcept {
  wire::SettingsAnswer out{.result = wire::SettingsResult::kUnsupported};
  const std::span<std::byte> space = payload.subspan(wire::kSettingsAnswerBytes);
  std::size_t text_bytes = 0;
  if (settings_ != nullptr) {
    out = settings_->serve(
        asked, text,
        {.peer = asker_of(request), .now = request.now, .access = access, .key_id = key_id}, space,
        text_bytes);
    text_bytes = std::min(text_bytes, space.size());
  }
  out.request_id = asked.request_id;
  out.cookie = cookies_.make(request.from, request.now);
  wire::encode_settings_answer(out, payload.first<wire::kSettingsAnswerBytes>());
  return wire::kSettingsAnswerBytes + text_bytes;
}

RequestHandler::Answer RequestHandler::answer_cookie(const Request& request,
                                                     std::uint32_t request_id) noexcept {
  if (!may_answer_unproven(request, wire::kSettingsAnswerBytes)) {
    return {};
  }
  count(Count::kCookies);
  return answer({.request_id = request_id,
                 .result = wire::SettingsResult::kCookie,
                 .cookie = cookies_.make(request.from, request.now)},
                0);
}

RequestHandler::Answer RequestHandler::subscribe_cookie(const Request& request,
                                                        std::uint32_t request_id) noexcept {
  if (!may_answer_unproven(request, wire::kSubscribedBytes)) {
    return {};
  }
  count(Count::kCookies);
  return answer(request, {.request_id = request_id, .result = wire::SubscribeResult::kCookie});
}

RequestHandler::Answer RequestHandler::discover(const Request& request) noexcept {
  const Result<wire::Discover> asked = wire::decode_discover(request.packet.payload);
  // The length first: a discover without its padding is an attempt to get more than was sent.
  if (!may_answer_unproven(request, wire::kAnnounceBytes)) {
    return {};
  }
  if (!asked) {
    return refuse(Count::kBadField);
  }
  count(Count::kAccepted);
  announce_.request_id = asked->request_id;
  announce_.subscribers = static_cast<std::uint8_t>(subscribers_.count());
  announce_.most_subscribers = kMostSubscribers;
  wire::encode_announce(announce_, wire::payload_space(buffer_).first<wire::kAnnounceBytes>());
  return seal(PacketType::kAnnounce, wire::kAnnounceBytes);
}

bool RequestHandler::may_answer_unproven(const Request& request,
                                         std::size_t payload_bytes) noexcept {
  if (wire::kHeaderBytes + payload_bytes + wire::kCrcBytes > request.datagram.size()) {
    count(Count::kTooShort);
    return false;
  }
  if (!limits_.may_answer_unproven(request.from, request.now)) {
    count(Count::kBusy);
    return false;
  }
  return true;
}

bool RequestHandler::may_serve(const Request& request) noexcept {
  const bool served = limits_.may_serve(request.from, request.now);
  if (!served) {
    count(Count::kBusy);
  }
  return served;
}

RequestHandler::Answer RequestHandler::answer(const Request& request,
                                              const wire::Subscribed& subscribed) noexcept {
  put_subscribed(subscribed, request, wire::payload_space(buffer_));
  return seal(PacketType::kSubscribed, wire::kSubscribedBytes);
}

void RequestHandler::put_subscribed(wire::Subscribed subscribed, const Request& request,
                                    std::span<std::byte> payload) noexcept {
  subscribed.subscribers = static_cast<std::uint8_t>(subscribers_.count());
  subscribed.cookie = cookies_.make(request.from, request.now);
  wire::encode_subscribed(subscribed, payload.first<wire::kSubscribedBytes>());
}

// The text lies behind the answer already.
RequestHandler::Answer RequestHandler::answer(const wire::SettingsAnswer& settings,
                                              std::size_t text_bytes) noexcept {
  wire::encode_settings_answer(settings,
                               wire::payload_space(buffer_).first<wire::kSettingsAnswerBytes>());
  return seal(PacketType::kSettingsAnswer, wire::kSettingsAnswerBytes + text_bytes);
}

RequestHandler::Answer RequestHandler::seal(PacketType type, std::size_t payload_bytes) noexcept {
  return wire::seal_packet({.type = type, .origin = origin_, .frame = {.health = health_}},
                           payload_bytes, buffer_);
}

RequestHandler::Answer RequestHandler::refuse(Count why) noexcept {
  count(why);
  return {};
}

void RequestHandler::count(Count what) noexcept {
  // One thread writes; the others only have to see whole numbers.
  std::atomic<std::uint64_t>& counter = counts_[static_cast<std::size_t>(what)];
  counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

RequestHandler::Count RequestHandler::reason(PacketFault fault) noexcept {
  switch (fault) {
    case PacketFault::kTruncated:
      return Count::kTruncated;
    case PacketFault::kMagic:
      return Count::kBadMagic;
    case PacketFault::kVersion:
      return Count::kBadVersion;
    case PacketFault::kLength:
      return Count::kBadLength;
    case PacketFault::kCrc:
      return Count::kBadCrc;
    case PacketFault::kField:
      break;
  }
  return Count::kBadField;
}

wire::ControlCounters RequestHandler::counters() const noexcept {
  const auto of = [this](Count what) {
    return counts_[static_cast<std::size_t>(what)].load(std::memory_order_relaxed);
  };
  return {.accepted = of(Count::kAccepted),
          .truncated = of(Count::kTruncated),
          .bad_magic = of(Count::kBadMagic),
          .bad_version = of(Count::kBadVersion),
          .bad_length = of(Count::kBadLength),
          .bad_crc = of(Count::kBadCrc),
          .bad_field = of(Count::kBadField),
          .not_control = of(Count::kNotControl),
          .foreign = of(Count::kForeign),
          .too_short = of(Count::kTooShort),
          .cookies = of(Count::kCookies),
          .busy = of(Count::kBusy),
          .forged = of(Count::kForged),
          .replayed = of(Count::kReplayed)};
}

}  // namespace stof::firmware
