#pragma once

#include <chrono>
#include <span>

#include "firmware/control/lease_table.h"
#include "firmware/control/link_way.h"
#include "firmware/control/periodic_task.h"
#include "firmware/control/receiver_list.h"
#include "firmware/control/request_handler.h"
#include "firmware/wire/messages/structs.h"
#include "hal/datagram_port.h"
#include "hal/time.h"

namespace stof::firmware {

// The parts of the control thread; all of them outlive ControlServer. Until the thread has ended,
// `handler`, `subscribers`, receive() of the port and the tasks are its own; the loop sends through
// the port and reads `ring` and RequestHandler::counters().
struct ControlParts {
  hal::DatagramPort& port;
  RequestHandler& handler;
  LeaseTable& subscribers;
  ReceiverRing& ring;
  std::span<PeriodicTask* const> tasks{};
  hal::DatagramPort* link = nullptr;  // takes broadcasts; nullptr: nobody is answered by one
  // How long a quiet turn takes: between two rounds of the tasks.
  hal::Duration turn = std::chrono::milliseconds(20);
};

// The turns of the control thread. Each answers requests, ends leases, tells the
// loop who receives, runs the tasks. No clock, no heap.
class ControlServer {
 public:
  // Datagrams between two rounds of the tasks: a flood keeps them waiting for some milliseconds at
  // most.
  static constexpr int kDatagramsPerTurn = 256;

  explicit ControlServer(const ControlParts& parts) noexcept : parts_(parts) {}

  // Waits up to `wait` for a datagram and answers all that have come, up to kDatagramsPerTurn. The
  // port's status where it is gone: kDeviceLost, else kOk. An answer that the port does not take is
  // dropped: whoever asked asks again. Who asks over a link (link_way.h) is answered so.
  Status receive(hal::Duration wait, hal::Time (*now)() noexcept) noexcept;
  // Does what is due at `now`.
  void tick(hal::Time now) noexcept;

 private:
  ControlParts parts_;
  wire::DatagramBuffer space_{};
  ReceiverList pushed_{};  // what the loop has
};

// With the datagrams that the port lost before they were read. For any thread.
wire::ControlCounters control_counters(const RequestHandler& handler,
                                       const hal::DatagramPort& port) noexcept;

}  // namespace stof::firmware
