#pragma once

#include <cstdint>

#include "firmware/control/cookie.h"
#include "firmware/control/link_way.h"
#include "firmware/control/source_limiter.h"
#include "firmware/control/token_bucket.h"
#include "hal/datagram_port.h"
#include "hal/time.h"

namespace stof::firmware {

// How many requests are served: no host gets more than its share, so that one that floods keeps
// nobody else out, and whoever writes somebody else's address on its requests reaches it with few
// answers. `now` must not go back.
class RequestLimits {
 public:
  static constexpr std::uint32_t kUnprovenPerSecond = 1000;  // of all hosts together
  static constexpr std::uint32_t kUnprovenPerHost = 200;     // of these
  static constexpr std::uint32_t kProvenPerHost = 1000;
  // Of these, answers to what no key signed or what is repeated: who guesses learns no more, and an
  // answer costs more than the judgement.
  static constexpr std::uint32_t kRefusedPerHost = 50;
  // Over a link, of all its hosts: every one of them hears each answer, and nobody proves an
  // address there. Those that show no cookie, and those that do, apart.
  static constexpr std::uint32_t kOverLink = 20;

  explicit RequestLimits(const CookieSecret& secret) noexcept
      : unproven_hosts_(secret, kUnprovenPerHost),
        proven_hosts_(secret, kProvenPerHost),
        refused_hosts_(secret, kRefusedPerHost) {}

  // Whether a source that has shown no valid cookie is answered. The host first: what it is refused
  // takes nothing of what all share.
  bool may_answer_unproven(const hal::Peer& from, hal::Time now) noexcept {
    return is_over_link(from) ? unproven_links_.take(now)
                              : unproven_hosts_.take(from, now) && unproven_.take(now);
  }
  // Whether one that showed a cookie is served.
  bool may_serve(const hal::Peer& from, hal::Time now) noexcept {
    return is_over_link(from) ? links_.take(now) : proven_hosts_.take(from, now);
  }
  // Whether it is told that what it signed was refused.
  bool may_refuse(const hal::Peer& from, hal::Time now) noexcept {
    return is_over_link(from) || refused_hosts_.take(from, now);
  }

 private:
  TokenBucket unproven_{kUnprovenPerSecond};
  TokenBucket unproven_links_{kOverLink};
  TokenBucket links_{kOverLink};
  SourceLimiter unproven_hosts_;
  SourceLimiter proven_hosts_;
  SourceLimiter refused_hosts_;
};

}  // namespace stof::firmware
