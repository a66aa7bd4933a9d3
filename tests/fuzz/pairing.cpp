#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "firmware/keys/keyring.h"
#include "firmware/keys/pairing_server.h"
#include "tests/firmware/keys/pairing_client.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/pairing_steps.h"
#include "tests/fuzz/reached.h"
#include "tests/fuzz/repeatable_keys.h"

// Pairing: a sensor, honest clients whose steps come in any order, whoever changes their requests,
// and anything else in between: pairing_steps.h. No key comes of it but one whose client's
// user was content, by digits only where somebody accepted them at the sensor; and nothing
// that comes over the network opens the sensor or accepts for it.
namespace stof {
namespace {

using fuzz::PairingStep;
using keys::PairingWay;
using wire::PairMethod;
using wire::PairResult;
using wire::Role;

constexpr wire::Origin kSensor{.device_id = 1, .session_id = 7};
constexpr keys::LabelCode kCode{std::byte{5}};
constexpr std::size_t kClients = 4;

enum Place : std::uint8_t {
  kOpenedByButton,
  kEndedByButton,
  kOpenedByCable,
  kWindowOver,
  kBegunDigits,
  kBegunCode,
  kBegunCable,
  kBegunKey,
  kRevealedDigits,
  kRevealedOther,
  kWaiting,
  kAcceptedFirst,
  kHeldTooEarly,
  kDoneDigitsButton,
  kDoneDigitsCable,
  kDoneCode,
  kDoneCable,
  kRenewed,
  kRenewedAgain,
  kTwoClients,
  kFull,
  kWrongPoint,
  kWrongDigits,
  kWrongOther,
  kClosedToTheNetwork,
  kPlaces
};
constinit const std::array<const char*, kPlaces> kPlaceNames{
    "opened by the button",
    "ended by the button, with a client",
    "opened by the cable",
    "the two minutes over, with a client",
    "begun with digits",
    "begun with the code",
    "begun over the cable",
    "begun with a key",
    "revealed, digits told",
    "revealed, without digits",
    "the client's user content, the sensor waits",
    "accepted at the sensor before the client's user",
    "held since before the digits were told, not accepted",
    "key by digits, accepted with the button",
    "key by digits, accepted over the cable",
    "key by the code",
    "key over the cable",
    "key renewed",
    "key renewed again with the secret from before",
    "two clients, both ended",
    "a seventeenth key",
    "a point that is no public key, refused",
    "other digits over the cable, ended",
    "wrong otherwise: commitment, tag, attempt",
    "open or accept over the network, closed",
};

fuzz::Reached<kPlaces>& reached() {
  static fuzz::Reached<kPlaces> places(kPlaceNames);
  return places;
}

struct Client {
  Client(PairMethod method, Role role, std::span<const std::byte> before = {},
         std::uint32_t key_id = 0)
      : known(wire::Secret{}), steps(kSensor, method, role, keep(before), key_id) {}
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  wire::Secret known;
  test::PairingClient steps;
  wire::PairAnswer newest{};
  bool revealed = false;  // to a sensor that answered
  bool again = false;     // renews with the secret from before

 private:
  std::span<const std::byte> keep(std::span<const std::byte> before) {
    std::ranges::copy(before, known.begin());
    return std::span(known).first(before.size());
  }
};

// What a client's user is content with: only then its tag goes to the sensor.
struct Consent {
  wire::PairTranscript said;
  wire::Secret secret;
  bool again;
};

struct World {
  explicit World(const keys::Keyring& known) : ring(known) { remember(); }

  void remember() {
    had = 0;
    for (const wire::Key& key : ring.keys().all()) {
      secrets[had++] = beginning(key.secret);
    }
  }
  static std::uint64_t beginning(const wire::Secret& secret) {
    return wire::get_u64(std::span(secret).first<8>());
  }

  keys::Keyring ring;
  keys::PairingServer server{kSensor, ring, kCode};
  std::array<std::optional<Client>, kClients> clients;
  std::vector<Consent> consents;
  // The digits are told, as the sensor's thread does after each request.
  void tell() {
    server.tick(now);
    if (server.digits() != told) {
      told = server.digits();
      told_at = now;
    }
  }

  hal::Time now{std::chrono::seconds(1000)};
  std::optional<std::uint32_t> told;
  hal::Time told_at{};
  bool accepted = false;                                     // the digits of this window
  bool by_cable = false;                                     // and how
  bool renewed = false;                                      // some key, once
  std::array<std::uint64_t, keys::kMostKeys + 1> secrets{};  // how they begin, before this step
  std::size_t had = 0;
};

// With 0, 1 ... 16 keys: made once.
const keys::Keyring& ring_of(std::size_t count) {
  static const std::vector<keys::Keyring> rings = [] {
    keys::Keyring ring(nullptr, nullptr);
    std::vector<keys::Keyring> made{ring};
    for (std::uint32_t id = 1; id <= keys::kMostKeys; ++id) {
      fuzz::require(ring.add(test::numbered_key(id, Role::kTune)) == Status::kOk);
      made.push_back(ring);
    }
    return made;
  }();
  return rings[count % rings.size()];
}

wire::PairRequest consent(World& world, Client& client) {
  world.consents.push_back({.said = client.steps.said(),
                            .secret = client.steps.secrets().secret(),
                            .again = client.again});
  return client.steps.confirm();
}

void note_key(World& world, const wire::Key& key, const Consent& owner) {
  switch (owner.said.method) {
    case PairMethod::kDigits:
      reached().note(world.by_cable ? kDoneDigitsCable : kDoneDigitsButton);
      return;
    case PairMethod::kCode:
      reached().note(kDoneCode);
      return;
    case PairMethod::kCable:
      reached().note(kDoneCable);
      return;
    case PairMethod::kKey:
      reached().note(owner.again ? kRenewedAgain : kRenewed);
      world.renewed = true;
      fuzz::require(key.former.has_value());
      return;
  }
}

// What is new in the ring is known to a client whose user was content, and is what he said.
void check_keys(World& world, bool may_change) {
  for (const wire::Key& key : world.ring.keys().all()) {
    const auto before = std::span(world.secrets).first(world.had);
    if (std::ranges::find(before, World::beginning(key.secret)) != before.end()) {
      continue;
    }
    fuzz::require(may_change);
    const auto owner = std::ranges::find(world.consents, key.secret, &Consent::secret);
    fuzz::require(owner != world.consents.end());
    const wire::PairTranscript& said = owner->said;
    fuzz::require(said.key_id == key.id && said.role == key.role && said.name == key.name);
    fuzz::require(said.method != PairMethod::kDigits || world.accepted);
    note_key(world, key, *owner);
  }
  fuzz::require(world.ring.keys().count() <= keys::kMostKeys);
  world.remember();
}

void note_answer(const wire::PairRequest& request, PairResult result) {
  const bool begins = request.step == wire::PairStep::kBegin;
  if (result == PairResult::kBusy && begins && request.method == PairMethod::kDigits) {
    reached().note(kTwoClients);
  } else if (result == PairResult::kFull) {
    reached().note(kFull);
  } else if (result == PairResult::kWaiting && request.step != wire::PairStep::kOpen) {
    reached().note(request.step == wire::PairStep::kConfirm ? kWaiting : kAcceptedFirst);
  } else if (result == PairResult::kWrong) {
    reached().note(request.step == wire::PairStep::kAccept ? kWrongDigits : kWrongOther);
  } else if (result == PairResult::kOk && begins) {
    reached().note(kBegunDigits + static_cast<std::size_t>(request.method));
  } else if (result == PairResult::kOk && request.step == wire::PairStep::kReveal) {
    reached().note(request.method == PairMethod::kDigits ? kRevealedDigits : kRevealedOther);
  }
}

wire::PairAnswer ask(World& world, const wire::PairRequest& request, PairingWay way) {
  const bool was_open = world.server.is_open();
  const std::optional<std::uint32_t> told = world.server.digits();
  const wire::PairAnswer answer = world.server.serve(request, way, world.now);
  world.tell();
  const bool of_the_cable =
      request.step == wire::PairStep::kOpen || request.step == wire::PairStep::kAccept;
  if (way == PairingWay::kNetwork) {
    fuzz::require(was_open || !world.server.is_open());
    if (of_the_cable) {
      fuzz::require(answer.result == PairResult::kClosed && world.server.digits() == told);
      reached().note(kClosedToTheNetwork);
    }
  } else if (request.step == wire::PairStep::kOpen && answer.result == PairResult::kOk &&
             answer.key_id == 0) {
    reached().note(kOpenedByCable);
    world.accepted = world.accepted && world.server.digits().has_value();
  } else if (request.step == wire::PairStep::kAccept && told &&
             wire::get_u32(std::as_bytes(std::span(request.value)).first<4>()) == *told) {
    world.accepted = true;
    world.by_cable = true;
  }
  note_answer(request, answer.result);
  check_keys(world, request.step == wire::PairStep::kConfirm || of_the_cable);
  return answer;
}

void begin(World& world, std::optional<Client>& client, PairingWay way) {
  client->newest = ask(world, client->steps.begin(), way);
}

void reveal(World& world, Client& client, const wire::PairAnswer& begun, PairingWay way) {
  client.revealed = begun.result == PairResult::kOk;
  static_cast<void>(ask(world, client.steps.reveal(begun), way));
}

void confirm(World& world, Client& client, PairingWay way) {
  if (!client.revealed) {
    return;
  }
  const wire::PairAnswer answer = ask(world, consent(world, client), way);
  const wire::PairSecrets secrets = client.steps.secrets();
  if (answer.result == PairResult::kOk &&
      wire::bytes_in<wire::Tag>(answer.value) == secrets.done_tag()) {
    // Who is told that it is done has the key that the sensor has, until that is renewed.
    const wire::Key* const key = world.ring.keys().find(answer.key_id);
    fuzz::require(key == nullptr || key->secret == secrets.secret() || world.renewed);
  }
}

void renew(World& world, std::optional<Client>& client, PairingWay way) {
  if (world.ring.keys().count() == 0) {
    return;
  }
  const wire::Key key = world.ring.keys().all()[0];
  const bool again = key.former && way == PairingWay::kNetwork;
  client.emplace(PairMethod::kKey, key.role, again ? *key.former : key.secret, key.id);
  client->again = again;
  client->steps.said().name = key.name;
  begin(world, client, PairingWay::kNetwork);
}

// A bit of a request changes on its way. Where that bit says nothing, it is served as it was.
void flipped(World& world, Client& client, PairingWay way, std::span<const std::byte> how) {
  const auto which = wire::get_u8(how.first<1>());
  const auto at = wire::get_u8(how.last<1>());
  wire::PairRequest request = client.steps.begin();
  if (which % 3 != 0 && client.newest.result == PairResult::kOk) {
    request = client.steps.reveal(client.newest);
    client.revealed = true;
    request = which % 3 == 1 ? request : consent(world, client);
  }
  std::array<std::byte, wire::kPairRequestBytes> payload{};
  wire::encode_pair_request(request, payload);
  payload[at % payload.size()] ^= static_cast<std::byte>(1U << (which >> 2U & 7U));
  if (const auto changed = wire::decode_pair_request(payload)) {
    const wire::PairAnswer answer = ask(world, *changed, way);
    if (changed->step == wire::PairStep::kBegin) {
      client.newest = answer;
    }
  }
}

// Points with which anybody would know what the exchange gives (of small order), and any other
// byte.
wire::PublicKey point_of(std::uint8_t which) {
  wire::PublicKey point{};
  switch (which) {
    case 0:
      return point;
    case 1:
      point[0] = std::byte{1};
      return point;
    case 2:
    case 3:
    case 4:  // p - 1, p, p + 1
      point.fill(std::byte{0xFF});
      point[0] = static_cast<std::byte>(0xEC + which - 2);
      point[31] = std::byte{0x7F};
      return point;
    default:
      point.fill(static_cast<std::byte>(which));
      return point;
  }
}

void show_point(World& world, PairMethod method, PairingWay way, std::uint8_t which) {
  const wire::PublicKey point = point_of(which);
  const wire::PairNonce nonce{};
  wire::PairRequest request{.step = wire::PairStep::kBegin, .method = method, .role = Role::kAdmin};
  std::ranges::copy(wire::key_name("eve"), request.name.begin());
  wire::put_bytes(wire::commitment_of(point, nonce), request.value);
  const wire::PairAnswer begun = ask(world, request, way);
  if (begun.result != PairResult::kOk) {
    return;
  }
  request.step = wire::PairStep::kReveal;
  request.attempt = begun.attempt;
  request.value = {};
  wire::put_bytes(point, request.value);
  const PairResult result = ask(world, request, way).result;
  if (which < 5) {
    fuzz::require(result == PairResult::kWrong);
    reached().note(kWrongPoint);
  }
}

void press(World& world) {
  const bool was_told = world.server.digits().has_value();
  world.server.press(world.now);
  fuzz::require(!was_told || !world.server.is_open());
  fuzz::require(!world.server.digits());
  world.tell();
  world.accepted = false;
  world.by_cable = false;
  reached().note(world.server.is_open() ? kOpenedByButton : kEndedByButton);
}

// early: since before anything that was told at this time.
void hold(World& world, bool early) {
  const hal::Time released = early ? world.now - std::chrono::milliseconds(1) : world.now;
  const bool read = world.server.digits() && released >= world.told_at;
  if (read) {
    world.accepted = true;
    world.by_cable = false;
  }
  world.server.hold(released);
  if (world.server.digits()) {
    reached().note(read ? kAcceptedFirst : kHeldTooEarly);
  }
  check_keys(world, read);
  world.tell();
}

void wait(World& world, std::uint8_t byte) {
  const bool begun = world.server.digits().has_value();
  world.now += std::chrono::seconds(1U << (byte >> 5U));
  world.tell();
  if (begun && !world.server.digits()) {
    reached().note(kWindowOver);
  }
}

void change_keys(World& world, unsigned who) {
  if (world.ring.keys().count() > 0) {
    const std::uint32_t first = world.ring.keys().all()[0].id;
    if (who < 2) {
      fuzz::require(world.ring.remove(first) == Status::kOk);
    } else {
      world.ring.settle(first);
    }
  }
  world.remember();
}

void ask_by_cable(World& world, PairingStep step, unsigned who, PairingWay way) {
  wire::PairRequest request{.step = wire::PairStep::kOpen, .role = Role::kAdmin};
  if (step == PairingStep::kOpen) {
    request.nonce[0] = static_cast<std::uint8_t>(who);
  } else {
    request.step = wire::PairStep::kAccept;
    const std::uint32_t digits = world.server.digits().value_or(0) + (who == 3 ? 1 : 0);
    wire::put_u32(std::as_writable_bytes(std::span(request.value)).first<4>(), digits);
  }
  static_cast<void>(ask(world, request, way));
}

void anything(World& world, PairingWay way, std::span<const std::byte> bytes) {
  std::array<std::byte, wire::kPairRequestBytes> payload{};
  static_assert(payload.size() == fuzz::kAnythingBytes);
  std::ranges::copy(bytes, payload.begin());
  if (const auto request = wire::decode_pair_request(payload)) {
    static_cast<void>(ask(world, *request, way));
  }
}

// after: what follows the step in the input, as many bytes as bytes_after() says, or fewer.
void step(World& world, std::uint8_t byte, std::span<const std::byte> after) {
  const unsigned who = byte >> 4U & 3U;
  std::optional<Client>& client = world.clients[who];
  const auto way = (byte & fuzz::kCableBit) != 0 ? PairingWay::kCable : PairingWay::kNetwork;
  const Role role = static_cast<Role>(who % 3 + 1);
  const PairingStep what = fuzz::step_of(byte);
  const bool whole = after.size() == fuzz::bytes_after(byte);
  switch (what) {
    case PairingStep::kBeginDigits:
      client.emplace(PairMethod::kDigits, role);
      return begin(world, client, way);
    case PairingStep::kBeginCode:
      client.emplace(PairMethod::kCode, role, kCode);
      return begin(world, client, way);
    case PairingStep::kBeginCable:
      client.emplace(PairMethod::kCable, role);
      return begin(world, client, way);
    case PairingStep::kReveal:
      return client ? reveal(world, *client, client->newest, way) : void();
    case PairingStep::kMixed: {
      const auto& next = world.clients[(who + 1) % kClients];
      return client && next ? reveal(world, *client, next->newest, way) : void();
    }
    case PairingStep::kConfirm:
      return client ? confirm(world, *client, way) : void();
    case PairingStep::kPress:
      return press(world);
    case PairingStep::kHold:
      return hold(world, way == PairingWay::kCable);
    case PairingStep::kWait:
      return wait(world, byte);
    case PairingStep::kKeys:
      return change_keys(world, who);
    case PairingStep::kRenew:
      return renew(world, client, way);
    case PairingStep::kOpen:
    case PairingStep::kAccept:
      return ask_by_cable(world, what, who, way);
    case PairingStep::kPoint:
      return whole ? show_point(world, static_cast<PairMethod>(who % 3), way,
                                wire::get_u8(after.first<1>()))
                   : void();
    case PairingStep::kFlipped:
      return client && whole ? flipped(world, *client, way, after) : void();
    case PairingStep::kAnything:
      return anything(world, way, after);
  }
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  static const bool ready = wire::start_crypto();
  require(ready);
  if (input.empty()) {
    return;
  }
  const auto first = wire::get_u8(input.first<1>());
  begin_random(first);
  reached().begin_run();
  World world(ring_of(first));
  std::span<const std::byte> rest = input.subspan(1);
  for (std::size_t i = 0; i < kMostSteps && !rest.empty(); ++i) {
    const auto byte = wire::get_u8(rest.first<1>());
    rest = rest.subspan(1);
    const std::size_t after = std::min(rest.size(), bytes_after(byte));
    step(world, byte, rest.first(after));
    rest = rest.subspan(after);
  }
}
