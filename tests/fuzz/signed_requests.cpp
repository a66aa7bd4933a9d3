#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <vector>

#include "firmware/control/request_handler.h"
#include "firmware/keys/key_service.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/settings_server.h"
#include "firmware/upload/upload_server.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/messages/settings_answer.h"
#include "firmware/wire/messages/subscribed.h"
#include "hal/store.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/reached.h"

// Requests behind the tag: whoever has a key may send any payload of any type. Each record's first
// byte is the type within the signed packet; its flags say whose key signs it (kSeal: a good tag),
// from which of four ports, and whether the counter is one that was (kCookie). What a role may not
// do changes nothing, nor does what was seen before; each answer is signed with the same key.
namespace stof {
namespace {

using wire::PacketType;
using wire::SettingsResult;

constexpr wire::Origin kHere{.device_id = 1, .session_id = 77};
constexpr std::size_t kCookieAt = 8;
constexpr std::size_t kMostRequests = 24;  // of a run: more of them find nothing else

enum Place : std::uint8_t {
  kUnknownKey,
  kStale,
  kDocument,
  kRefused,
  kDenied,
  kChanged,
  kStaged,
  kCommitted,
  kNotSaved,
  kUnsupported,
  kKeysListed,
  kKeyEnded,
  kEndedKeyRefused,
  kStreamKey,
  kNoPlace,
  kUnsubscribed,
  kUploading,
  kUploaded,
  kReverted,
  kNoAnswer,
  kPlaces
};
constinit const std::array<const char*, kPlaces> kPlaceNames{
    "another tag: no answer is signed",
    "a counter that was: stale",
    "a document, or a part of it",
    "a field or text refused",
    "denied to the role",
    "settings in force that were not",
    "staged",
    "committed, what was staged in force",
    "saved or committed too often",
    "an operation that is none here",
    "keys listed",
    "a key ended",
    "a key that was ended, refused",
    "a stream key handed over",
    "no place for one more subscriber",
    "unsubscribed",
    "a part of an upload there",
    "a whole upload with its hash",
    "back to what was there before uploads",
    "too short, or a type that is not signed",
};

fuzz::Reached<kPlaces>& reached() {
  static fuzz::Reached<kPlaces> places(kPlaceNames);
  return places;
}

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
    changed = true;
    return true;
  }
  bool may_change = false;
  bool changed = false;

 private:
  std::uint32_t newest_ = 1;
};

// Takes whatever whoever may save saves.
class CheckingStore final : public hal::Store {
 public:
  explicit CheckingStore(const CheckingSink& sink) : sink_(sink) {}
  Result<std::optional<std::size_t>> load(std::span<std::byte> /*space*/) noexcept override {
    return std::nullopt;
  }
  Status save(std::span<const std::byte> bytes) noexcept override {
    fuzz::require(sink_.may_change && !bytes.empty());
    fuzz::touch(bytes);
    return Status::kOk;
  }
  Status set_aside() noexcept override { return Status::kOk; }

 private:
  const CheckingSink& sink_;
};

// Takes what an admin uploads, never more than he said.
class CheckingTarget final : public upload::Target {
 public:
  SettingsResult begin(std::uint32_t total, settings::PagedWriter& why) noexcept override {
    fuzz::require(by_admin && total > 0);
    total_ = total;
    bytes_.clear();
    if (total > kMostBytes) {
      why << "too much";
      return SettingsResult::kInvalid;
    }
    return SettingsResult::kOk;
  }
  SettingsResult write(std::span<const std::byte> bytes,
                       settings::PagedWriter& /*why*/) noexcept override {
    fuzz::require(by_admin && !bytes.empty() && bytes_.size() + bytes.size() <= total_);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    reached().note(kUploading);
    return SettingsResult::kOk;
  }
  SettingsResult commit(const firmware::Requester& /*by*/,
                        settings::PagedWriter& /*why*/) noexcept override {
    fuzz::require(by_admin && bytes_.size() == total_);
    fuzz::require(wire::digest_of({}, {bytes_}) == hash);
    reached().note(kUploaded);
    return SettingsResult::kOk;
  }
  SettingsResult revert(const firmware::Requester& /*by*/,
                        settings::PagedWriter& /*why*/) noexcept override {
    fuzz::require(by_admin);
    reached().note(kReverted);
    return SettingsResult::kOk;
  }
  upload::Versions versions() const noexcept override { return {}; }
  std::span<const std::byte> file_in_force() const noexcept override { return {}; }

  bool by_admin = false;
  wire::Digest hash{};  // that the request names

 private:
  static constexpr std::uint32_t kMostBytes = 4096;

  std::uint32_t total_ = 0;
  std::vector<std::byte> bytes_;
};

struct World {
  explicit World(const keys::Keyring& known) : ring(known) {
    fuzz::require(subscribers.fix({.address = {9}, .port = 9}));
  }

  keys::Keyring ring;
  keys::Authenticator authenticator{ring};
  AnyLimits limits;
  CheckingSink sink;
  CheckingStore store{sink};
  settings::SettingsServer server{{}, {}, {.limits = limits, .sink = sink, .store = &store}};
  keys::KeyService key_service{ring, server};
  firmware::LeaseTable subscribers;
  CheckingTarget target;
  upload::UploadServer uploads{key_service, target};
  firmware::RequestHandler handler{kHere, firmware::CookieSecret{}, subscribers, &uploads,
                                   &authenticator};
  hal::Time now{std::chrono::seconds(1'000'000)};
  std::uint64_t counter = 0;
};

constexpr std::size_t kKeys = 3;
const std::array<wire::Key, kKeys>& all_keys() {
  static const std::array keys{test::numbered_key(11, wire::Role::kAdmin),
                               test::numbered_key(12, wire::Role::kTune),
                               test::numbered_key(13, wire::Role::kView)};
  return keys;
}

const keys::Keyring& ring_of_all() {
  static const keys::Keyring ring = [] {
    keys::Keyring made(nullptr, nullptr);
    for (const wire::Key& key : all_keys()) {
      fuzz::require(made.add(key) == Status::kOk);
    }
    return made;
  }();
  return ring;
}

struct Sent {
  const wire::Key& key;
  PacketType type;
  std::optional<wire::SettingsRequest> settings{};  // where it is one
  bool replayed;
};

void note_settings(const Sent& sent, SettingsResult result, bool changed) {
  using wire::SettingsOperation;
  const SettingsOperation operation = sent.settings->operation;
  switch (result) {
    case SettingsResult::kDenied:
      return reached().note(kDenied);
    case SettingsResult::kInvalid:
      return reached().note(kRefused);
    case SettingsResult::kUnsupported:
      return reached().note(kUnsupported);
    case SettingsResult::kNotSaved:
      return reached().note(kNotSaved);
    case SettingsResult::kOk:
      break;
    default:
      return;
  }
  switch (operation) {
    case SettingsOperation::kGet:
      return reached().note(kDocument);
    case SettingsOperation::kStage:
      return reached().note(kStaged);
    case SettingsOperation::kKeys:
      fuzz::require(sent.key.role == wire::Role::kAdmin);
      return reached().note(kKeysListed);
    case SettingsOperation::kUnpair:
      return reached().note(kKeyEnded);
    case SettingsOperation::kUpload:
      fuzz::require(sent.key.role == wire::Role::kAdmin);
      return;
    case SettingsOperation::kCommit:
      return changed ? reached().note(kCommitted) : void();
    default:
      return changed ? reached().note(kChanged) : void();
  }
}

// What the key signed is answered so that whoever has the key can tell.
void judge(const World& world, const Sent& sent, std::span<const std::byte> answer) {
  const auto packet = wire::parse_packet(answer);
  fuzz::require(packet.has_value());
  if (packet->header.type != PacketType::kSignedAnswer) {  // the key was ended
    fuzz::require(!world.ring.keys().find(sent.key.id));
    return reached().note(kEndedKeyRefused);
  }
  const auto view = wire::open_signed(*packet, answer);
  fuzz::require(view && wire::signed_with(sent.key.secret, *view));
  fuzz::require(view->fields.key_id == sent.key.id);
  if (sent.settings) {
    const auto settings = wire::decode_settings_answer(view->payload);
    fuzz::require(settings.has_value());
    fuzz::require(sent.replayed == (settings->result == SettingsResult::kStale));
    return sent.replayed ? reached().note(kStale)
                         : note_settings(sent, settings->result, world.sink.changed);
  }
  const auto subscribed = wire::decode_subscribed(view->payload);
  fuzz::require(subscribed.has_value());
  switch (subscribed->result) {
    case wire::SubscribeResult::kOk:
    case wire::SubscribeResult::kRawTaken:
      fuzz::require(view->payload.size() == wire::kSubscribedBytes + wire::kStreamKeyFieldsBytes);
      return reached().note(kStreamKey);
    case wire::SubscribeResult::kFull:
      return reached().note(kNoPlace);
    case wire::SubscribeResult::kEnded:
      return reached().note(kUnsubscribed);
    default:
      fuzz::require(sent.replayed);
      return reached().note(kStale);
  }
}

void take(World& world, const fuzz::Record& record) {
  world.now += std::chrono::seconds(record.seconds());
  const wire::Key& key = all_keys()[record.peer() % kKeys];
  const hal::Peer peer{.address = {1, 2, 3},
                       .port = static_cast<std::uint16_t>(9000 + record.peer())};
  wire::DatagramBuffer buffer{};
  const std::span<std::byte> payload = wire::signed_space(buffer);
  const auto inner =
      record.bytes.subspan(1).first(std::min(record.bytes.size() - 1, payload.size()));
  std::ranges::copy(inner, payload.begin());
  if (inner.size() >= kCookieAt + 8) {
    wire::put_u64(payload.subspan(kCookieAt).first<8>(),
                  firmware::Cookies(firmware::CookieSecret{}).make(peer, world.now));
  }
  const auto type = static_cast<PacketType>(record.bytes[0]);
  const auto request = type == PacketType::kSettingsRequest
                           ? wire::decode_settings_request(payload.first(inner.size()))
                           : fail(Status::kCorrupt);
  const bool good = (record.flags & fuzz::kSeal) != 0;
  const bool replayed = (record.flags & fuzz::kCookie) != 0;
  wire::Secret with = key.secret;
  with[0] ^= good ? std::byte{0} : std::byte{1};
  const auto datagram = wire::seal_signed({.type = PacketType::kSignedRequest, .origin = kHere},
                                          {.key_id = key.id,
                                           .type = static_cast<std::uint8_t>(record.bytes[0]),
                                           .counter = replayed ? 0 : ++world.counter},
                                          inner.size(), with, buffer);
  world.sink.may_change = good && !replayed && key.role != wire::Role::kView;
  world.sink.changed = false;
  world.target.by_admin = good && !replayed && key.role == wire::Role::kAdmin;
  if (request && inner.size() >= wire::kSettingsRequestBytes + wire::kUploadRequestBytes) {
    std::ranges::copy(inner.subspan(wire::kSettingsRequestBytes)
                          .first<wire::kUploadRequestBytes>()
                          .last<sizeof(wire::Digest)>(),
                      world.target.hash.begin());
  }
  const std::size_t keys = world.ring.keys().count();
  const std::size_t receivers = world.subscribers.count();
  const std::span<const std::byte> answer = world.handler.take(datagram, peer, world.now);
  const firmware::ReceiverList list = world.subscribers.list();
  fuzz::require(list.raw_receiver < list.count ? list.raw.pictures != 0
                                               : list.raw_receiver == firmware::kMostSubscribers);
  const bool ended = world.ring.keys().count() < keys;
  fuzz::require(!ended || (good && !replayed && request &&
                           request->operation == wire::SettingsOperation::kUnpair));
  fuzz::require(!ended || key.role == wire::Role::kAdmin || !world.ring.keys().find(key.id));
  if (answer.empty()) {
    fuzz::require(world.subscribers.count() == receivers);
    return reached().note(kNoAnswer);
  }
  if (!good) {
    const auto packet = wire::parse_packet(answer);
    fuzz::require(packet && packet->header.type != PacketType::kSignedAnswer);
    fuzz::require(world.subscribers.count() == receivers);
    return reached().note(kUnknownKey);
  }
  judge(world,
        {.key = key,
         .type = type,
         .settings = request ? std::optional(*request) : std::nullopt,
         .replayed = replayed},
        answer);
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  static const bool ready = wire::start_crypto();
  require(ready);
  reached().begin_run();
  World world(ring_of_all());
  std::size_t requests = 0;
  for_each_record(input, [&](const Record& record) {
    if (!record.bytes.empty() && ++requests <= kMostRequests) {
      take(world, record);
    }
  });
}
