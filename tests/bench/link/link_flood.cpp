#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <thread>

#include <poll.h>
#include <sys/socket.h>

#include "posix/udp_socket.h"
#include "tests/bench/link/link_bench.h"
#include "tests/firmware/control/requests.h"
#include "tests/support/random.h"

namespace stof::bench {
namespace {

using client::Time;
using test::Bytes;
using test::Random;
using wire::PacketType;

// As what the sensor has to count it. A forged cookie is answered with a real one, or refused while
// too many are.
enum Reason : std::uint8_t {
  kTruncated,
  kBadMagic,
  kBadVersion,
  kBadLength,
  kBadCrc,
  kBadField,
  kNotControl,
  kForeign,
  kTooShort,
  kForged,
  kReasons
};
constexpr std::array<const char*, kReasons> kNames{
    "truncated", "bad_magic",   "bad_version", "bad_length", "bad_crc",
    "bad_field", "not_control", "foreign",     "too_short",  "forged"};

struct Datagram {
  Bytes bytes;
  Reason reason;
};

Bytes noise(Random& random, std::size_t size) {
  Bytes bytes(size);
  for (std::byte& byte : bytes) {
    byte = static_cast<std::byte>(random.next());
  }
  return bytes;
}

// Subscribe, unsubscribe or a settings request with any cookie.
Bytes request(Random& random, std::uint32_t device_id = 0) {
  const auto id = static_cast<std::uint32_t>(random.next());
  const std::uint64_t cookie = random.next();
  switch (random.between(0, 2)) {
    case 0:
      return test::subscribe({.request_id = id, .lease_ms = 3000, .cookie = cookie},
                             PacketType::kSubscribe, device_id);
    case 1:
      return test::subscribe({.request_id = id, .cookie = cookie}, PacketType::kUnsubscribe,
                             device_id);
    default:
      break;
  }
  if (device_id == 0) {
    return test::settings({.request_id = id, .cookie = cookie}, R"({"name":"mine"})");
  }
  return test::subscribe({.request_id = id, .cookie = cookie}, PacketType::kSubscribe, device_id);
}

Bytes flipped(Random& random, int first, int last) {
  Bytes bytes = request(random);
  const int end = last >= 0 ? last : static_cast<int>(bytes.size()) + last;
  bytes[static_cast<std::size_t>(random.between(first, end))] ^=
      static_cast<std::byte>(1U << static_cast<unsigned>(random.between(0, 7)));
  return bytes;
}

Bytes not_control(Random& random) {
  constexpr std::array<PacketType, 6> kTypes{PacketType::kTile,       PacketType::kFrameInfo,
                                             PacketType::kHealth,     PacketType::kParity,
                                             PacketType::kSubscribed, PacketType::kAnnounce};
  const PacketType type = kTypes[static_cast<std::size_t>(random.between(0, 5))];
  return test::sealed(type, noise(random, static_cast<std::size_t>(random.between(0, 1000))));
}

Datagram malformed(Random& random) {
  constexpr int kLargest = 1472;  // a whole Ethernet frame
  const int most = static_cast<int>(wire::kMaxDatagram);
  switch (random.between(0, 12)) {
    case 0: {
      Bytes bytes = request(random);
      bytes.resize(static_cast<std::size_t>(random.between(0, static_cast<int>(bytes.size()) - 1)));
      return {std::move(bytes), kTruncated};
    }
    case 1:
      return {noise(random, static_cast<std::size_t>(random.between(0, 55))), kTruncated};
    case 2:
      return {noise(random, static_cast<std::size_t>(random.between(56, most))), kBadMagic};
    case 3:
      return {flipped(random, 0, 3), kBadMagic};
    case 4:
      return {flipped(random, 4, 4), kBadVersion};
    case 5: {
      Bytes bytes = request(random);
      const Bytes tail = noise(random, static_cast<std::size_t>(random.between(1, 200)));
      bytes.insert(bytes.end(), tail.begin(), tail.end());
      return {std::move(bytes), kBadLength};
    }
    case 6:
      return {noise(random, static_cast<std::size_t>(random.between(most + 1, kLargest))),
              kBadLength};
    case 7:
      return {flipped(random, 8, 48), kBadCrc};
    case 8:
      return {flipped(random, static_cast<int>(wire::kHeaderBytes), -1), kBadCrc};
    case 9:
      return {test::sealed(PacketType::kSubscribe,
                           noise(random, static_cast<std::size_t>(random.between(0, 8)))),
              kBadField};
    case 10:
      return {not_control(random), kNotControl};
    case 11:
      return {request(random, static_cast<std::uint32_t>(random.between(1000, 1'000'000))),
              kForeign};
    default:
      break;
  }
  if (random.between(0, 7) == 0) {
    return {test::sealed(PacketType::kDiscover,
                         noise(random, static_cast<std::size_t>(random.between(4, 40)))),
            kTooShort};
  }
  return {request(random), kForged};
}

// One sender: what it says and what it is told.
struct Source {
  posix::UdpSocket socket;
  std::uint64_t sent_bytes = 0;
  std::uint64_t answered_bytes = 0;
  std::uint64_t answers = 0;
};

void drain(Source& source) {
  std::array<std::byte, 2048> space;
  while (const auto bytes = source.socket.receive(space)) {
    source.answered_bytes += *bytes;
    ++source.answers;
  }
}

class Flood {
 public:
  static constexpr std::size_t kBatch = 64;

  Flood(const std::string& place, std::uint64_t seed) : random_(seed) {
    constexpr int kSources = 8;
    const auto target = posix::split_host_port(place);
    const auto found =
        target ? posix::resolve(*target, posix::Names::kLookUp) : std::unexpected(std::string());
    for (int i = 0; i < kSources && found; ++i) {
      Source& source = sources_.emplace_back();
      source.socket = posix::UdpSocket(found->front().family());
      if (source.socket.connect(found->front()) != 0) {
        sources_.clear();
        return;
      }
    }
  }
  bool ready() const { return !sources_.empty(); }

  // Up to kBatch datagrams, each another one.
  std::uint64_t send_batch(std::size_t count) {
    Source& source = sources_[turn_++ % sources_.size()];
    std::array<Datagram, kBatch> datagrams;
    std::array<iovec, kBatch> vectors{};
    std::array<mmsghdr, kBatch> messages{};
    for (std::size_t i = 0; i < count; ++i) {
      datagrams[i] = malformed(random_);
      vectors[i] = {.iov_base = datagrams[i].bytes.data(), .iov_len = datagrams[i].bytes.size()};
      messages[i].msg_hdr.msg_iov = &vectors[i];
      messages[i].msg_hdr.msg_iovlen = 1;
    }
    const int sent =
        sendmmsg(source.socket.fd(), messages.data(), static_cast<unsigned>(count), MSG_DONTWAIT);
    for (std::size_t i = 0; sent > 0 && i < static_cast<std::size_t>(sent); ++i) {
      ++counts_[datagrams[i].reason];
      source.sent_bytes += datagrams[i].bytes.size();
    }
    drain(source);
    return sent > 0 ? static_cast<std::uint64_t>(sent) : 0;
  }

  void finish(Time::duration took) {
    for (int i = 0; i < 50; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      std::ranges::for_each(sources_, drain);
    }
    std::uint64_t sent = 0;
    std::printf(R"({"seconds":%.3f,"reasons":{)", 1e-3 * milliseconds(took));
    for (std::size_t i = 0; i < kReasons; ++i) {
      sent += counts_[i];
      std::printf("%s\"%s\":%llu", i == 0 ? "" : ",", kNames[i],
                  static_cast<unsigned long long>(counts_[i]));
    }
    std::printf(R"(},"sent":%llu,"sources":[)", static_cast<unsigned long long>(sent));
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      std::printf("%s[%llu,%llu,%llu]", i == 0 ? "" : ",",
                  static_cast<unsigned long long>(sources_[i].sent_bytes),
                  static_cast<unsigned long long>(sources_[i].answered_bytes),
                  static_cast<unsigned long long>(sources_[i].answers));
    }
    std::printf("]}\n");
  }

 private:
  Random random_;
  std::vector<Source> sources_;
  std::size_t turn_ = 0;
  std::array<std::uint64_t, kReasons> counts_{};
};

}  // namespace

int flood(const Words& words) {
  const auto number = [&words](std::size_t at) {
    return std::strtoull(words[at].c_str(), nullptr, 10);
  };
  Flood flood(words[0], number(3));
  const std::uint64_t count = number(1);
  const auto rate = static_cast<double>(number(2));
  if (!flood.ready() || rate <= 0) {
    std::fprintf(stderr, "stof_link_bench: cannot send to %s\n", words[0].c_str());
    return 2;
  }
  const Time began = Time::clock::now();
  for (std::uint64_t sent = 0; sent < count;) {
    const auto due = began + std::chrono::duration_cast<Time::duration>(
                                 std::chrono::duration<double>(static_cast<double>(sent) / rate));
    std::this_thread::sleep_until(due);
    sent += flood.send_batch(std::min<std::uint64_t>(Flood::kBatch, count - sent));
  }
  flood.finish(Time::clock::now() - began);
  return 0;
}

}  // namespace stof::bench
