#include <algorithm>
#include <array>
#include <optional>

#include "firmware/control/request_handler.h"
#include "firmware/keys/key_service.h"
#include "tests/firmware/keys/pairing_client.h"
#include "tests/fuzz/fuzz_input.h"

// Pairing: a sensor, honest clients whose steps come in any order, and anything else in between.
// Each byte of the input is what happens next. No key comes of it but where the sensor's digits
// were accepted, or the client knew the code, or held the cable, and then the client knows it.
namespace stof {
namespace {

using wire::PairMethod;
using wire::PairResult;

constexpr wire::Origin kSensor{.device_id = 1, .session_id = 7};
constexpr keys::LabelCode kCode{std::byte{5}};
constexpr std::size_t kClients = 4;

struct Client {
  explicit Client(PairMethod method, wire::Role role = wire::Role::kAdmin,
                  std::span<const std::byte> known = {}, std::uint32_t key_id = 0)
      : steps(kSensor, method, role, known, key_id) {}

  test::PairingClient steps;
  wire::PairAnswer newest{};
  bool revealed = false;  // to a sensor that answered
};

struct World {
  keys::Keyring ring{nullptr, nullptr};
  keys::PairingServer server{kSensor, ring, kCode};
  std::array<std::optional<Client>, kClients> clients;
  hal::Time now{std::chrono::seconds(1000)};
  int accepted = 0;  // digits that the sensor told
};

void ask(World& world, const wire::PairRequest& request, keys::PairingWay way,
         std::optional<Client>& client) {
  const std::size_t before = world.ring.keys().count();
  const wire::PairAnswer answer = world.server.serve(request, way, world.now);
  const bool added = world.ring.keys().count() > before;
  fuzz::require(!added || request.step == wire::PairStep::kConfirm);
  fuzz::require(!added || answer.result == PairResult::kOk);
  if (added && request.method == PairMethod::kDigits) {
    fuzz::require(world.accepted > 0);
  }
  if (answer.result == PairResult::kOk && client && request.step == wire::PairStep::kConfirm &&
      client->revealed) {
    // Who is told that it is done has the key that the sensor has.
    const wire::Key* const key = world.ring.keys().find(answer.key_id);
    const wire::PairSecrets secrets = client->steps.secrets();
    const bool ours = wire::bytes_in<wire::Tag>(answer.value) == secrets.done_tag();
    fuzz::require(!ours || key == nullptr || key->secret == secrets.secret() ||
                  request.method == PairMethod::kKey);
  }
  if (client && request.step == wire::PairStep::kBegin) {
    client->newest = answer;
  }
}

void step(World& world, std::uint8_t byte, std::span<const std::byte>& rest) {
  std::optional<Client>& client = world.clients[byte >> 4U & 3U];
  const auto way = (byte & 0x80U) != 0 ? keys::PairingWay::kCable : keys::PairingWay::kNetwork;
  switch (byte & 15U) {
    case 0:
    case 1:
    case 2: {
      const auto method = static_cast<PairMethod>(byte & 15U);
      client.emplace(method, wire::Role::kAdmin,
                     method == PairMethod::kCode ? std::span<const std::byte>(kCode)
                                                 : std::span<const std::byte>());
      ask(world, client->steps.begin(), way, client);
      break;
    }
    case 3:
      if (client) {
        client->revealed = client->newest.result == PairResult::kOk;
        ask(world, client->steps.reveal(client->newest), way, client);
      }
      break;
    case 4:
      if (client && client->revealed) {
        ask(world, client->steps.confirm(), way, client);
      }
      break;
    case 5:
      world.server.open(world.now);
      break;
    case 6:
      world.accepted += world.server.digits() ? 1 : 0;
      world.server.accept();
      break;
    case 7:
      world.now += std::chrono::seconds(1U << (byte >> 5U));
      world.server.tick(world.now);
      break;
    case 8:
      if (world.ring.keys().count() > 0) {
        fuzz::require(world.ring.remove(world.ring.keys().all()[0].id) == Status::kOk);
      }
      break;
    case 9:
      if (world.ring.keys().count() > 0) {
        const wire::Key key = world.ring.keys().all()[0];
        client.emplace(PairMethod::kKey, key.role, std::span<const std::byte>(), key.id);
        ask(world, client->steps.begin(), way, client);
      }
      break;
    default: {  // anything
      std::array<std::byte, wire::kPairRequestBytes> payload{};
      const std::size_t bytes = std::min(rest.size(), payload.size());
      std::ranges::copy(rest.first(bytes), payload.begin());
      rest = rest.subspan(bytes);
      if (const auto request = wire::decode_pair_request(payload)) {
        std::optional<Client> nobody;
        const std::size_t before = world.ring.keys().count();
        ask(world, *request, way, nobody);
        fuzz::require(world.ring.keys().count() == before);
      }
    }
  }
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  require(wire::start_crypto());
  World world;
  std::span<const std::byte> rest = input;
  for (int i = 0; i < 200 && !rest.empty(); ++i) {
    const auto byte = wire::get_u8(rest.first<1>());
    rest = rest.subspan(1);
    step(world, byte, rest);
    require(world.ring.keys().count() <= keys::kMostKeys);
  }
}
