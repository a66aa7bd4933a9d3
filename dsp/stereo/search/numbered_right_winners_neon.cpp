#include "dsp/stereo/search/numbered_right_winners.h"

#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/search/numbered_right_winners_body.h"

namespace stof::dsp::neon {
namespace {

// Two vectors, which one instruction loads.
struct NumberedLanes {
  using L = Lanes<std::uint16_t>;
  using V = uint16x8x2_t;
  static constexpr std::size_t kLanes = 16;

  static V load(const std::uint16_t* p) noexcept { return vld1q_u16_x2(p); }
  static V repeated(const std::uint16_t* p) noexcept { return {{L::load(p), L::load(p)}}; }
  static V all(std::uint16_t v) noexcept { return {{L::all(v), L::all(v)}}; }
  static V smaller(V a, V b) noexcept { return each(L::smaller, a, b); }
  static V either(V a, V b) noexcept {
    return each([](auto x, auto y) noexcept { return vorrq_u16(x, y); }, a, b);
  }
  static V add(V a, V b) noexcept {
    return each([](auto x, auto y) noexcept { return vaddq_u16(x, y); }, a, b);
  }
  static V number_where_equal(V number, V a, V lowest) noexcept {
    return either(number, each([](auto x, auto y) noexcept { return vcgtq_u16(x, y); }, a, lowest));
  }
  static V winners_of(V lowest, V number) noexcept {
    const auto winner = [](auto of, auto n) noexcept {
      return vorrq_u16(n, vshlq_n_u16(vandq_u16(of, vdupq_n_u16(7)), 3));
    };
    return each(winner, lowest, number);
  }
  static V better(V a, V b) noexcept {
    return each(
        [](auto x, auto y) noexcept { return vcltq_u16(vshrq_n_u16(x, 3), vshrq_n_u16(y, 3)); }, a,
        b);
  }
  static V select(V mask, V a, V b) noexcept {
    return {
        {L::select(mask.val[0], a.val[0], b.val[0]), L::select(mask.val[1], a.val[1], b.val[1])}};
  }

  template <int kSkipped>
  static V first_of(const std::uint16_t* column) noexcept {
    const auto none = L::all(kNoCost<std::uint16_t>);
    if constexpr (kSkipped > 8) {
      return {{none, L::joined<16 - kSkipped>(none, L::load(column))}};
    } else if constexpr (kSkipped == 8) {
      return {{none, L::load(column)}};
    } else {
      return {{L::joined<8 - kSkipped>(none, L::load(column)), L::load(column + 8 - kSkipped)}};
    }
  }
  template <int kSkipped>
  static V last_of(const std::uint16_t* column) noexcept {
    const auto none = L::all(kNoCost<std::uint16_t>);
    if constexpr (kSkipped >= 8) {
      return {{L::joined<kSkipped - 8>(L::load(column + 8), none), none}};
    } else {
      return {{L::load(column + kSkipped), L::joined<kSkipped>(L::load(column + 8), none)}};
    }
  }
  static void store(V lowest, V winner, std::int16_t* to) noexcept {
    const V out = either(winner, each(L::equal, lowest, all(kNoCost<std::uint16_t>)));
    vst1q_s16(to, vreinterpretq_s16_u16(out.val[0]));
    vst1q_s16(to + 8, vreinterpretq_s16_u16(out.val[1]));
  }

 private:
  template <typename Call>
  static V each(Call call, V a, V b) noexcept {
    return {{call(a.val[0], b.val[0]), call(a.val[1], b.val[1])}};
  }
};

}  // namespace

void numbered_right_winners(std::span<const std::uint16_t> costs, int lanes,
                            std::span<std::int16_t> winners) noexcept {
  numbered_right_winners_body::find<NumberedLanes>(costs, lanes, winners);
}

}  // namespace stof::dsp::neon
