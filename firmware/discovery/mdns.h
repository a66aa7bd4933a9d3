#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "firmware/control/token_bucket.h"
#include "firmware/discovery/mdns_links.h"
#include "firmware/discovery/mdns_records.h"
#include "firmware/wire/dns.h"
#include "firmware/wire/packet.h"
#include "hal/datagram_port.h"
#include "hal/network_interfaces.h"
#include "hal/time.h"

namespace stof::firmware {

// A multicast DNS responder (RFC 6762) for one sensor: probes for its names, announces them,
// answers questions, takes another name where someone else has it. Datagrams and time in, datagrams
// out: no socket, no clock, no heap. Peers carry their interface in `scope`, also those of IPv4.
//
// Anybody can forge a question or a rival. Whoever asks from another port than 5353, or for an
// answer to itself alone, gets one that is no longer than its question, or none, and all together
// kAlonePerSecond of them; else the answer goes to all. A name that was given up is tried again
// after kRenamed.
//
// Not done: RFC 6762 section 7.4 (silence when another one has answered) and section 6.5 beyond
// A, AAAA, SRV and TXT. A record is not multicast again within a second.
class Responder {
 public:
  static constexpr std::uint16_t kPort = 5353;
  static constexpr std::uint32_t kAlonePerSecond = 50;
  static constexpr hal::Duration kRenamed = std::chrono::minutes(10);

  struct Datagram {
    hal::Peer to;
    std::span<const std::byte> bytes;  // valid until the next call of anything
  };

  // seed: differs from sensor to sensor.
  Responder(const Service& service, std::uint32_t seed) noexcept;

  // The addresses now. Where they changed, it begins anew. Those beyond
  // MdnsLinks::kMostAddresses are left out.
  void set_addresses(std::span<const hal::InterfaceAddress> addresses, hal::Time now) noexcept;
  // Says goodbye for the old names where they change.
  void set_service(const Service& service, hal::Time now) noexcept;

  // Takes any bytes that came to port 5353, from anybody. Returns the answer to their sender, if
  // any.
  std::optional<Datagram> take(std::span<const std::byte> message, const hal::Peer& from,
                               hal::Time now) noexcept;
  // A datagram for all. To be called until it returns nothing, then again within 20 ms.
  std::optional<Datagram> next(hal::Time now) noexcept;

  // Says goodbye: next() gives the datagrams, then nothing until set_addresses().
  void stop(hal::Time now) noexcept;

  const wire::dns::Name& instance() const noexcept { return records_.instance(); }
  const wire::dns::Name& host() const noexcept { return records_.host(); }
  bool established() const noexcept { return phase_ == Phase::kSteady; }

 private:
  enum class Phase : std::uint8_t { kProbe, kAnnounce, kSteady, kGoodbye, kStopped };
  struct Asked {
    RecordSet alone = 0;  // to the one who asks
    RecordSet all = 0;
    std::optional<wire::dns::Question> first{};  // that has an answer
  };

  void enter(Phase phase, hal::Time due) noexcept;
  void next_step(hal::Time now) noexcept;
  void take_response(wire::dns::Reader& reader, const wire::dns::Header& header,
                     hal::Time now) noexcept;
  std::optional<Asked> read_questions(wire::dns::Reader& reader, unsigned count,
                                      std::uint32_t interface, bool legacy) const noexcept;
  std::optional<Datagram> take_query(wire::dns::Reader& reader, const wire::dns::Header& header,
                                     const hal::Peer& from, MdnsLink& link, std::size_t bytes,
                                     hal::Time now) noexcept;
  // None where it would be longer than `most` bytes.
  std::optional<Datagram> answer_alone(std::span<const wire::dns::Question> questions,
                                       RecordSet answers, std::uint16_t id, const hal::Peer& to,
                                       std::size_t most) noexcept;
  void take_back_name(hal::Time now) noexcept;
  static void schedule(MdnsLink& link, RecordSet answers, hal::Time due) noexcept;
  void break_tie(wire::dns::Reader& reader, const wire::dns::Header& header,
                 hal::Time now) noexcept;
  void resolve_conflict(hal::Time now) noexcept;
  std::optional<Datagram> step(const MdnsLink& link) noexcept;
  std::optional<Datagram> flush(MdnsLink& link, hal::Time now) noexcept;
  std::uint32_t random(std::uint32_t below) noexcept;

  Service service_;
  std::optional<Service> replacement_{};  // after the goodbye
  unsigned suffix_ = 1;
  Records records_;
  MdnsLinks links_;

  Phase phase_ = Phase::kStopped;
  unsigned steps_ = 0;         // of this phase that are done
  hal::Time step_due_{};       // of the next one
  std::size_t step_link_ = 0;  // that it goes to next
  unsigned conflicts_ = 0;     // since conflicts_since_
  hal::Time conflicts_since_{};
  std::uint32_t random_;
  TokenBucket alone_{kAlonePerSecond};
  wire::DatagramBuffer buffer_{};
};

}  // namespace stof::firmware
