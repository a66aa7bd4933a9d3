#include "firmware/control/cookie.h"

#include <algorithm>
#include <bit>

#include "firmware/wire/bytes.h"

namespace stof::firmware {
namespace {

constexpr std::size_t kWord = 8;

class SipState {
 public:
  SipState(std::uint64_t k0, std::uint64_t k1) noexcept
      : v0_(k0 ^ 0x736f6d6570736575),
        v1_(k1 ^ 0x646f72616e646f6d),
        v2_(k0 ^ 0x6c7967656e657261),
        v3_(k1 ^ 0x7465646279746573) {}

  void absorb(std::uint64_t word) noexcept {
    v3_ ^= word;
    rounds(2);
    v0_ ^= word;
  }
  std::uint64_t finish() noexcept {
    v2_ ^= 0xff;
    rounds(4);
    return v0_ ^ v1_ ^ v2_ ^ v3_;
  }

 private:
  void rounds(int count) noexcept {
    for (int i = 0; i < count; ++i) {
      v0_ += v1_;
      v1_ = std::rotl(v1_, 13) ^ v0_;
      v0_ = std::rotl(v0_, 32);
      v2_ += v3_;
      v3_ = std::rotl(v3_, 16) ^ v2_;
      v0_ += v3_;
      v3_ = std::rotl(v3_, 21) ^ v0_;
      v2_ += v1_;
      v1_ = std::rotl(v1_, 17) ^ v2_;
      v2_ = std::rotl(v2_, 32);
    }
  }

  std::uint64_t v0_, v1_, v2_, v3_;
};

std::uint64_t slot_of(hal::Time now) noexcept {
  return static_cast<std::uint64_t>(now.time_since_epoch() / Cookies::kSlot);
}

}  // namespace

std::uint64_t siphash24(const CookieSecret& key, std::span<const std::byte> message) noexcept {
  const std::span<const std::byte, 16> halves(key);
  SipState state(wire::get_u64(halves.first<kWord>()), wire::get_u64(halves.last<kWord>()));
  std::span<const std::byte> rest = message;
  while (rest.size() >= kWord) {
    state.absorb(wire::get_u64(rest.first<kWord>()));
    rest = rest.subspan(kWord);
  }
  std::array<std::byte, kWord> last{};
  std::ranges::copy(rest, last.begin());
  last.back() = static_cast<std::byte>(message.size());  // modulo 256
  state.absorb(wire::get_u64(last));
  return state.finish();
}

std::uint64_t Cookies::make(const hal::Peer& peer, hal::Time now) const noexcept {
  return of_slot(peer, slot_of(now));
}

bool Cookies::valid(std::uint64_t cookie, const hal::Peer& peer, hal::Time now) const noexcept {
  const std::uint64_t slot = slot_of(now);
  return cookie == of_slot(peer, slot) || cookie == of_slot(peer, slot - 1);
}

std::uint64_t Cookies::of_slot(const hal::Peer& peer, std::uint64_t slot) const noexcept {
  std::array<std::byte, 30> message{};
  const std::span<std::byte, 30> bytes(message);
  std::ranges::copy(std::as_bytes(std::span(peer.address)), bytes.begin());
  wire::put_u16(bytes.subspan<16, 2>(), peer.port);
  wire::put_u32(bytes.subspan<18, 4>(), peer.scope);
  wire::put_u64(bytes.subspan<22, 8>(), slot);
  return std::max<std::uint64_t>(siphash24(secret_, message), 1);
}

}  // namespace stof::firmware
