#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <thread>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/messages/pair_answer.h"
#include "firmware/wire/messages/pair_request.h"
#include "host/client/control/user_keys.h"
#include "posix/socket_address.h"
#include "posix/udp_socket.h"
#include "tests/bench/link/link_bench.h"
#include "tests/firmware/keys/signed_requests.h"
#include "tests/support/random.h"

namespace stof::bench {
namespace {

using client::Time;
using test::Bytes;
using test::Random;
using wire::PacketType;
using wire::SettingsOperation;
using wire::SettingsResult;

constexpr std::chrono::seconds kNewCaptures{8};  // a cookie is good for 16 s at least
constexpr std::size_t kCaptures = 8;             // at a time
constexpr std::size_t kKept = 64;                // of them, the newest
constexpr int kStrangers = 12;  // hosts: each has a share of its own of what is judged

enum Kind : std::uint8_t {
  kReplayed,   // a captured request, once more, from where it came
  kElsewhere,  // the same from another host
  kFlipped,    // with bits changed, and the check sum right
  kOwnCookie,  // with the cookie and a counter of whoever sends it
  kGuessed,    // a key id that there is, with a guessed tag
  kUnsigned,   // changes without a signature
  kPairing,    // steps of pairing, in any order, with guessed values
  kKinds
};
constexpr std::array<const char*, kKinds> kKindNames{
    "replayed", "elsewhere", "flipped", "own_cookie", "guessed", "unsigned", "pairing"};

// What nobody may change without a key on a sensor that has some.
constexpr std::array<std::string_view, 8> kChanges{R"({"name":"stolen"})",
                                                   R"({"udp":{"port":68}})",
                                                   R"({"serial":{"device":"/dev/watchdog0"}})",
                                                   R"({"period_ms":60000})",
                                                   R"({"depth":{"max_range_mm":500}})",
                                                   R"({"streams":{"depth":"off"}})",
                                                   R"({"limits":{"least_range_mm":1}})",
                                                   R"({"streams":{"parity":true}})"};

struct AttackSource {
  posix::UdpSocket socket;
  std::uint64_t cookie = 0;
};

class Attack {
 public:
  Attack(const std::string& place, std::uint64_t seed, const wire::Key& key)
      : random_(seed), key_(key) {
    const auto target = posix::split_host_port(place);
    const auto found =
        target ? posix::resolve(*target, posix::Names::kLookUp) : std::unexpected(std::string());
    for (int host = 1; host <= 1 + kStrangers && found; ++host) {
      in_addr address{};
      address.s_addr = htonl(INADDR_LOOPBACK + static_cast<unsigned>(host - 1));
      AttackSource source{.socket = posix::UdpSocket(AF_INET)};
      if (source.socket.bind(posix::make_address(address, 0)) != 0 ||
          source.socket.connect(found->front()) != 0) {
        sources_.clear();
        return;
      }
      sources_.push_back(std::move(source));
    }
  }

  // Cookies for all, and the first captured requests of the key's holder. false: no answer.
  bool begin() {
    for (int attempt = 0; attempt < 100 && !capture(); ++attempt) {
      for (AttackSource& source : sources_) {
        static_cast<void>(source.socket.send(test::settings({.request_id = 1})));
      }
      listen(std::chrono::milliseconds(20));
    }
    return !captured_.empty();
  }

  // As the owner of the key: some changes that are served, for whoever listens. They set what is
  // set already.
  bool capture() {
    if (sources_.empty() || owner().cookie == 0 || origin_.device_id == 0) {
      return false;
    }
    for (std::size_t i = 0; i < kCaptures; ++i) {
      const Bytes request = test::signed_settings(
          key_, origin_, next_counter(),
          {.request_id = 2, .operation = SettingsOperation::kSet, .cookie = owner().cookie},
          i % 2 == 0 ? R"({"name":"owners"})" : R"({"streams":{"parity":false}})");
      const std::uint64_t before = served_;
      for (int attempt = 0; attempt < 50 && served_ == before; ++attempt) {
        if (attempt % 10 == 0) {
          static_cast<void>(owner().socket.send(request));
        }
        listen(std::chrono::milliseconds(2));
      }
      if (served_ > before) {
        captured_.push_back(request);
      }
    }
    if (captured_.size() > kKept) {
      captured_.erase(captured_.begin(), captured_.end() - kKept);
    }
    captured_at_ = Time::clock::now();
    return !captured_.empty();
  }

  // One try.
  void send() {
    const auto kind = static_cast<Kind>(random_.between(0, kKinds - 1));
    AttackSource& stranger = sources_[static_cast<std::size_t>(random_.between(1, kStrangers))];
    AttackSource& from =
        kind == kReplayed || (kind == kFlipped && random_.between(0, 1) == 0) ? owner() : stranger;
    if (from.socket.send(request(kind, from)) == 0) {
      ++counts_[kind];
    }
    if (Time::clock::now() - captured_at_ > kNewCaptures) {
      // The strangers' cookies age as well.
      for (AttackSource& source : sources_) {
        static_cast<void>(source.socket.send(test::settings({.request_id = 1})));
      }
      listen(std::chrono::milliseconds(5));
      capture();
    }
  }
  void listen(std::chrono::milliseconds time = std::chrono::milliseconds(0)) {
    const Time until = Time::clock::now() + time;
    do {
      for (AttackSource& source : sources_) {
        std::array<std::byte, 2048> space;
        while (const auto bytes = source.socket.receive(space)) {
          hear(source, std::span(space).first(*bytes));
        }
      }
      if (time.count() > 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    } while (Time::clock::now() < until);
  }

  void finish(Time::duration took) {
    listen(std::chrono::milliseconds(500));
    std::printf(R"({"seconds":%.3f,"tries":{)", 1e-3 * milliseconds(took));
    std::uint64_t sent = 0;
    for (std::size_t i = 0; i < kKinds; ++i) {
      sent += counts_[i];
      std::printf("%s\"%s\":%llu", i == 0 ? "" : ",", kKindNames[i],
                  static_cast<unsigned long long>(counts_[i]));
    }
    std::printf(
        R"(},"sent":%llu,"judged":%llu,"accepted":%llu,"owners":%llu,"revision":%u,"stale":%llu})"
        "\n",
        static_cast<unsigned long long>(sent), static_cast<unsigned long long>(judged_),
        static_cast<unsigned long long>(accepted_), static_cast<unsigned long long>(served_),
        revision_, static_cast<unsigned long long>(stale_));
  }

 private:
  AttackSource& owner() { return sources_.front(); }

  std::uint64_t next_counter() {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    counter_ = std::max(counter_ + 1,
                        static_cast<std::uint64_t>(
                            std::chrono::duration_cast<std::chrono::microseconds>(now).count()));
    return counter_;
  }
  const Bytes& any_captured() {
    return captured_[static_cast<std::size_t>(
        random_.between(0, static_cast<int>(captured_.size()) - 1))];
  }
  std::string_view any_change() {
    return kChanges[static_cast<std::size_t>(
        random_.between(0, static_cast<int>(kChanges.size()) - 1))];
  }

  Bytes request(Kind kind, const AttackSource& from) {
    switch (kind) {
      case kReplayed:
      case kElsewhere:
        return any_captured();
      case kFlipped:
        return flipped(any_captured());
      case kOwnCookie: {
        Bytes bytes = any_captured();
        const auto data = std::span(bytes).subspan(wire::kHeaderBytes);
        wire::put_u64(data.subspan<8, 8>(), next_counter());
        wire::put_u64(data.subspan<wire::kSignedFieldsBytes + 8, 8>(), from.cookie);
        return resealed(std::move(bytes));
      }
      case kGuessed: {
        wire::Key guess = key_;
        for (std::byte& byte : guess.secret) {
          byte = static_cast<std::byte>(random_.next());
        }
        return test::signed_settings(
            guess, origin_, next_counter(),
            {.request_id = 3, .operation = any_operation(), .cookie = from.cookie}, any_change());
      }
      case kUnsigned:
        return test::settings(
            {.request_id = 3, .operation = any_operation(), .cookie = from.cookie}, any_change());
      default:
        return pairing(from);
    }
  }
  // One that changes something.
  SettingsOperation any_operation() {
    constexpr std::array kAll{SettingsOperation::kSet,    SettingsOperation::kStage,
                              SettingsOperation::kCommit, SettingsOperation::kPreset,
                              SettingsOperation::kSave,   SettingsOperation::kReset,
                              SettingsOperation::kUnpair, SettingsOperation::kKeys};
    return kAll[static_cast<std::size_t>(random_.between(0, static_cast<int>(kAll.size()) - 1))];
  }
  Bytes flipped(Bytes bytes) {
    const int last = static_cast<int>(bytes.size() - wire::kCrcBytes) - 1;
    for (int flips = random_.between(1, 3); flips > 0; --flips) {
      bytes[static_cast<std::size_t>(random_.between(0, last))] ^=
          static_cast<std::byte>(1U << static_cast<unsigned>(random_.between(0, 7)));
    }
    return resealed(std::move(bytes));
  }
  static Bytes resealed(Bytes bytes) {
    const auto covered = std::span(bytes).first(bytes.size() - wire::kCrcBytes);
    wire::put_u32(std::span(bytes).last<wire::kCrcBytes>(), wire::crc32c(covered));
    return bytes;
  }
  Bytes pairing(const AttackSource& from) {
    wire::PairRequest request{.request_id = 4,
                              .step = static_cast<wire::PairStep>(random_.between(0, 4)),
                              .method = static_cast<wire::PairMethod>(random_.between(0, 3)),
                              .role = wire::Role::kAdmin,
                              .cookie = from.cookie,
                              .attempt = random_.between(0, 1) == 0 ? attempt_ : random_.next(),
                              .key_id = random_.between(0, 1) == 0 ? key_.id : 0};
    request.name[0] = 'x';
    for (std::uint8_t& byte : request.value) {
      byte = static_cast<std::uint8_t>(random_.next());
    }
    std::array<std::byte, wire::kPairRequestBytes> payload{};
    wire::encode_pair_request(request, payload);
    return test::sealed(PacketType::kPairRequest, payload);
  }

  // What the sensor says: whether somebody got what he may not have.
  void hear(AttackSource& source, std::span<const std::byte> datagram) {
    const auto packet = wire::parse_packet(datagram);
    if (!packet) {
      return;
    }
    if (const auto reply = test::settings_reply(datagram)) {
      source.cookie = reply->answer.cookie;
      if (reply->answer.result == SettingsResult::kCookie) {
        origin_ = packet->header.origin;
        return;
      }
      ++judged_;
      const bool active = reply->answer.result == SettingsResult::kOk ||
                          reply->answer.result == SettingsResult::kNotSaved;
      accepted_ += active ? 1 : 0;
    } else if (const auto signed_one = test::signed_reply(key_, datagram)) {
      ++judged_;
      if (signed_one->answer.result == SettingsResult::kStale) {
        ++stale_;
      } else if (&source == &owner() && signed_one->fields.counter == counter_) {
        source.cookie = signed_one->answer.cookie;
        revision_ = std::max(revision_, signed_one->answer.revision);
        ++served_;
      } else {
        ++accepted_;
      }
    } else if (packet->header.type == PacketType::kPairAnswer) {
      const auto answer = wire::decode_pair_answer(packet->payload);
      ++judged_;
      attempt_ = answer ? answer->attempt : attempt_;
      // With method key anybody may begin; that is not yet a key.
      const bool made = answer && answer->result == wire::PairResult::kOk &&
                        std::ranges::all_of(answer->nonce, [](auto byte) { return byte == 0; });
      accepted_ += made ? 1 : 0;
    }
  }

  Random random_;
  wire::Key key_;
  wire::Origin origin_{};
  std::vector<AttackSource> sources_;
  std::vector<Bytes> captured_;
  Time captured_at_{};
  std::uint64_t counter_ = 0;
  std::uint64_t attempt_ = 0;
  std::array<std::uint64_t, kKinds> counts_{};
  std::uint64_t judged_ = 0;    // answers to tries that were more than a cookie
  std::uint64_t accepted_ = 0;  // of these, what must not be
  std::uint64_t served_ = 0;    // the owner's own
  std::uint64_t stale_ = 0;
  std::uint32_t revision_ = 0;  // after the last of these
};

}  // namespace

int attack(const Words& words) {
  const auto number = [&words](std::size_t at) {
    return std::strtoull(words[at].c_str(), nullptr, 10);
  };
  const auto keys = client::read_user_keys(words[4]);
  if (!wire::start_crypto() || !keys || keys->count() == 0) {
    std::fprintf(stderr, "stof_link_bench: no keys in %s\n", words[4].c_str());
    return 2;
  }
  Attack attack(words[0], number(3), keys->all()[0]);
  const std::uint64_t count = number(1);
  const auto rate = static_cast<double>(number(2));
  if (rate <= 0 || !attack.begin()) {
    std::fprintf(stderr, "stof_link_bench: %s does not answer\n", words[0].c_str());
    return 2;
  }
  const Time began = Time::clock::now();
  for (std::uint64_t sent = 0; sent < count; ++sent) {
    if (sent % 10 == 0) {
      std::this_thread::sleep_until(
          began + std::chrono::duration_cast<Time::duration>(
                      std::chrono::duration<double>(static_cast<double>(sent) / rate)));
      attack.listen();
    }
    attack.send();
  }
  attack.finish(Time::clock::now() - began);
  return 0;
}

}  // namespace stof::bench
