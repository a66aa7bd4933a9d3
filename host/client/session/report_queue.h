#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "firmware/wire/packet.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// What a sensor said beside its frames, in which session, and when that arrived here.
template <typename Report>
struct Told {
  Report report{};
  wire::Origin from{};
  Time arrived{};
};
using ToldEvent = Told<wire::EventReport>;
using ToldHealth = Told<wire::HealthReport>;

// Reports that wait to be taken, in the order of arrival; the newest kMost of them.
template <typename Report, std::size_t kMost>
class ReportQueue {
 public:
  // False: the oldest was given up for it.
  bool push(const Told<Report>& told) {
    const bool full = in_ - out_ == kMost;
    out_ += full ? 1U : 0U;
    waiting_[in_++ % kMost] = told;
    return !full;
  }
  std::optional<Told<Report>> take() {
    return out_ == in_ ? std::nullopt : std::optional(waiting_[out_++ % kMost]);
  }
  // How many nobody took.
  std::size_t clear() {
    const std::size_t waited = in_ - out_;
    out_ = in_;
    return waited;
  }

 private:
  std::array<Told<Report>, kMost> waiting_{};
  std::size_t in_ = 0;   // ever
  std::size_t out_ = 0;  // taken or given up
};

}  // namespace stof::client
