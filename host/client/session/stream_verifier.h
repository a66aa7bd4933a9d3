#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/wire/keys/signed_stream.h"

namespace stof::client {

// Whether datagrams are what the sensor has signed for this receiver alone, each once: see "Signed
// streams" of docs/WIRE.md. No clock.
class StreamVerifier {
 public:
  static constexpr std::uint64_t kWindow = 1024;  // counters that are told apart

  enum class Verdict : std::uint8_t {
    kGood,
    kNotSigned,  // with a key that is not known here, or in another session than the newest key
    kKeyToCome,  // likewise, while an answer with a key, or what an earlier one signed, may come
    kForged,
    kDuplicate,
    kLate,  // its counter is so old that nobody knows whether it came
  };

  // The sensor signs with it from now on, in this session. What the key before it signed is good as
  // well, until the next one; what it signed in another session no more.
  void set_key(const wire::StreamKey& key, std::uint32_t session);
  bool has_key() const noexcept { return known_.front().tagger.key().number != 0; }

  // Whether the sensor was asked for a key and has not answered, or has just given one.
  void await_key(bool awaited) noexcept { awaits_key_ = awaited; }

  // Of a datagram that wire::parse_packet() took, and of its session. A good one's counter is used
  // up.
  Verdict judge(std::span<const std::byte> datagram, std::uint32_t session);
  std::uint64_t good() const noexcept { return good_; }
  // Of the key of the newest good one; 0: there was none.
  std::uint32_t good_number() const noexcept { return good_number_; }

 private:
  struct Known {
    wire::StreamTagger tagger;
    std::uint64_t highest = 0;
    std::bitset<kWindow> seen{};  // of the newest kWindow counters, by their remainder

    void use(std::uint64_t counter);
  };

  std::array<Known, 2> known_{};  // the newest first
  std::uint64_t good_ = 0;
  std::uint32_t good_number_ = 0;
  std::uint32_t session_ = 0;
  bool awaits_key_ = false;
};

}  // namespace stof::client
