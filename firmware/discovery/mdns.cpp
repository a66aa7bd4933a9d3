#include "firmware/discovery/mdns.h"

#include <algorithm>

namespace stof::firmware {
namespace {

namespace dns = wire::dns;
using namespace std::chrono_literals;
using Section = dns::Writer::Section;

constexpr unsigned kProbes = 3;
constexpr hal::Duration kProbeGap = 250ms;
constexpr unsigned kAnnouncements = 2;
constexpr hal::Duration kSecond = 1s;  // between announcements, and between answers to all
constexpr unsigned kManyConflicts = 15;
constexpr hal::Duration kConflictWindow = 10s;
constexpr hal::Duration kConflictPause = 5s;
constexpr unsigned kMostSuffix = 9999;
// More than anybody asks or tells at once.
constexpr unsigned kMostQuestions = 32;
constexpr unsigned kMostRecords = 256;

// RFC 6762 section 6: answers that others may give as well come spread in time.
constexpr hal::Duration kLeastDelay = 20ms;
constexpr std::uint32_t kSpreadMs = 100;
constexpr hal::Duration kMoreDelay = 400ms;

constexpr RecordSet kAll = kServicesPtr | kInstancePtr | kSrv | kTxt | kA | kAaaa | kHostNsec;
// Not the list of services: others offer this one, too.
constexpr RecordSet kLeaving = kInstancePtr | kSrv | kTxt | kA | kAaaa;

constexpr auto kGroup4 = hal::from_ipv4(224, 0, 0, 251);
constexpr std::array<std::uint8_t, 16> kGroup6{0xff, 0x02, 0, 0, 0, 0, 0, 0,
                                               0,    0,    0, 0, 0, 0, 0, 0xfb};

hal::Peer group_of(std::uint32_t interface, bool ipv6) noexcept {
  return {.address = ipv6 ? kGroup6 : kGroup4, .port = Responder::kPort, .scope = interface};
}

bool same_names(const Service& a, const Service& b) noexcept {
  return a.announce.serial == b.announce.serial && a.announce.name == b.announce.name &&
         a.announce.version == b.announce.version && a.announce.board == b.announce.board &&
         a.announce.port == b.announce.port && a.device_id == b.device_id;
}

}  // namespace

Responder::Responder(const Service& service, std::uint32_t seed) noexcept
    : service_(service), records_(service, suffix_), random_(seed | 1) {}

std::uint32_t Responder::random(std::uint32_t below) noexcept {
  random_ ^= random_ << 13;  // xorshift: Marsaglia 2003
  random_ ^= random_ >> 17;
  random_ ^= random_ << 5;
  return random_ % below;
}

void Responder::enter(Phase phase, hal::Time due) noexcept {
  phase_ = phase;
  steps_ = 0;
  step_due_ = due;
  step_link_ = 0;
  for (MdnsLink& link : links_.all()) {
    link.pending = 0;
  }
}

void Responder::set_addresses(std::span<const hal::InterfaceAddress> addresses,
                              hal::Time now) noexcept {
  if (links_.knows(addresses) && phase_ != Phase::kStopped) {
    return;
  }
  links_.set_addresses(addresses);
  records_.set_addresses(links_.addresses());
  if (phase_ != Phase::kGoodbye) {
    enter(Phase::kProbe, now + std::chrono::milliseconds(random(250)));
  }
}

void Responder::set_service(const Service& service, hal::Time now) noexcept {
  if (same_names(service, replacement_ ? *replacement_ : service_)) {
    return;
  }
  replacement_ = service;
  if (phase_ != Phase::kGoodbye) {
    enter(Phase::kGoodbye, now);
  }
}

void Responder::stop(hal::Time now) noexcept {
  replacement_.reset();
  enter(phase_ == Phase::kProbe || phase_ == Phase::kStopped ? Phase::kStopped : Phase::kGoodbye,
        now);
}

// Whoever has the name already keeps it; where both have it, the probes decide.
void Responder::resolve_conflict(hal::Time now) noexcept {
  if (now - conflicts_since_ > kConflictWindow) {
    conflicts_since_ = now;
    conflicts_ = 0;
  }
  ++conflicts_;
  if (phase_ == Phase::kProbe) {
    suffix_ = suffix_ < kMostSuffix ? suffix_ + 1 : 2;
    records_ = Records(service_, suffix_);
    records_.set_addresses(links_.addresses());
  }
  enter(Phase::kProbe, conflicts_ > kManyConflicts ? now + kConflictPause : now);
}

void Responder::next_step(hal::Time now) noexcept {
  step_link_ = 0;
  ++steps_;
  if (phase_ == Phase::kProbe) {
    step_due_ = now + kProbeGap;
    if (steps_ == kProbes) {
      enter(Phase::kAnnounce, step_due_);
    }
  } else if (phase_ == Phase::kAnnounce) {
    step_due_ = now + kSecond;
    if (steps_ == kAnnouncements) {
      phase_ = Phase::kSteady;
    }
  } else if (replacement_) {
    service_ = *replacement_;
    replacement_.reset();
    suffix_ = 1;
    records_ = Records(service_, suffix_);
    records_.set_addresses(links_.addresses());
    enter(Phase::kProbe, now);
  } else {
    enter(Phase::kStopped, now);
  }
}

std::optional<Responder::Datagram> Responder::take(std::span<const std::byte> message,
                                                   const hal::Peer& from, hal::Time now) noexcept {
  dns::Reader reader(message);
  const Result<dns::Header> header = reader.header();
  MdnsLink* const link = links_.link_of(from);
  if (!header || (header->flags & dns::kOpcode) != 0 || link == nullptr || !links_.reaches(from) ||
      from.port == 0 || phase_ == Phase::kStopped || phase_ == Phase::kGoodbye) {
    return std::nullopt;
  }
  if ((header->flags & dns::kResponse) == 0) {
    return take_query(reader, *header, from, *link, message.size(), now);
  }
  if (from.port == kPort) {
    take_response(reader, *header, now);
  }
  return std::nullopt;
}

void Responder::take_response(dns::Reader& reader, const dns::Header& header,
                              hal::Time now) noexcept {
  for (unsigned i = 0; i < std::min<unsigned>(header.questions, kMostQuestions); ++i) {
    if (!reader.question()) {
      return;
    }
  }
  const unsigned records = unsigned{header.answers} + header.authorities + header.additionals;
  for (unsigned i = 0; i < std::min(records, kMostRecords); ++i) {
    const Result<dns::Record> record = reader.record();
    if (!record) {
      return;
    }
    if (records_.conflict(reader, *record) != Records::Conflict::kNone) {
      resolve_conflict(now);
      return;
    }
  }
}

// Two probe at the same time: the one whose data are greater goes on, the other waits a second and
// then finds the name taken.
void Responder::break_tie(dns::Reader& reader, const dns::Header& header, hal::Time now) noexcept {
  bool below = false;
  bool above = false;
  for (unsigned i = 0; i < std::min<unsigned>(header.authorities, kMostRecords); ++i) {
    const Result<dns::Record> record = reader.record();
    if (!record) {
      return;
    }
    const Records::Conflict conflict = records_.conflict(reader, *record);
    below = below || conflict == Records::Conflict::kBelow;
    above = above || conflict == Records::Conflict::kAbove;
  }
  if (above && !below) {
    enter(Phase::kProbe, now + 1s);
  }
}

// What the questions of a message ask for; none where they cannot be read.
std::optional<Responder::Asked> Responder::read_questions(dns::Reader& reader, unsigned count,
                                                          std::uint32_t interface,
                                                          bool legacy) const noexcept {
  Asked asked;
  for (unsigned i = 0; i < count; ++i) {
    const Result<dns::Question> question = reader.question();
    if (!question) {
      return std::nullopt;
    }
    const RecordSet answers = records_.answers(*question, interface);
    const bool unicast = legacy || (question->klass & dns::kTopBit) != 0;
    (unicast ? asked.alone : asked.all) |= answers;
    if (answers != 0 && !asked.first) {
      asked.first = *question;
    }
  }
  return asked;
}

std::optional<Responder::Datagram> Responder::take_query(dns::Reader& reader,
                                                         const dns::Header& header,
                                                         const hal::Peer& from, MdnsLink& link,
                                                         std::size_t bytes,
                                                         hal::Time now) noexcept {
  const bool legacy = from.port != kPort;
  const bool probe = header.authorities > 0;
  if (header.questions > kMostQuestions || header.answers > kMostRecords) {
    return std::nullopt;
  }
  const std::optional<Asked> asked =
      read_questions(reader, header.questions, link.interface, legacy);
  if (!asked) {
    return std::nullopt;
  }
  RecordSet alone = asked->alone;
  RecordSet all = asked->all;
  RecordSet known = 0;
  for (unsigned i = 0; i < header.answers; ++i) {
    const Result<dns::Record> record = reader.record();
    if (!record) {
      return std::nullopt;
    }
    known |= records_.known(reader, *record, link.interface);
  }
  if (phase_ == Phase::kProbe) {
    if (probe) {
      break_tie(reader, header, now);
    }
    return std::nullopt;  // the names are not ours yet
  }
  if (header.questions == 0 && link.more_from == from) {
    link.pending = static_cast<RecordSet>(link.pending & ~known);
  }
  if (probe) {
    // To all: on a machine with several responders an answer to one may reach another. And it may
    // follow the announcement sooner than usual (section 6).
    all |= alone;
    for (std::optional<hal::Time>& sent : link.sent) {
      sent = sent && now - *sent < kProbeGap ? sent : std::nullopt;
    }
  }
  all = static_cast<RecordSet>(all & ~known);
  alone = static_cast<RecordSet>(alone & ~known);
  std::optional<Datagram> answer;
  if (alone != 0 && alone_.take(now)) {
    using Questions = std::span<const dns::Question>;
    answer = answer_alone(legacy ? Questions(&*asked->first, 1) : Questions{}, alone,
                          legacy ? header.id : std::uint16_t{0}, from, bytes);
  }
  if (alone != 0 && !answer && !legacy) {
    all |= alone;  // who speaks multicast DNS hears it there as well
  }
  if (all != 0) {
    const bool more = (header.flags & dns::kTruncated) != 0;
    hal::Duration delay{};
    if (!probe && (more || (all & kShared) != 0)) {
      delay = (more ? kMoreDelay : kLeastDelay) + std::chrono::milliseconds(random(kSpreadMs));
    }
    schedule(link, all, now + delay);
    link.more_from = more ? std::optional(from) : std::nullopt;
  }
  return answer;
}

void Responder::schedule(MdnsLink& link, RecordSet answers, hal::Time due) noexcept {
  link.due = link.pending == 0 ? due : std::min(link.due, due);
  link.pending |= answers;
}

std::optional<Responder::Datagram> Responder::answer_alone(std::span<const dns::Question> questions,
                                                           RecordSet answers, std::uint16_t id,
                                                           const hal::Peer& to,
                                                           std::size_t most) noexcept {
  const ResponseKind response =
      questions.empty() ? ResponseKind::kMulticast : ResponseKind::kLegacy;
  if (most < dns::kHeaderBytes) {
    return std::nullopt;
  }
  dns::Writer writer(std::span<std::byte>(buffer_).first(std::min(most, buffer_.size())), id,
                     dns::kResponse | dns::kAuthoritative);
  for (const dns::Question& question : questions) {
    static_cast<void>(writer.question(question.name, question.type, dns::kInternet));
  }
  records_.write(writer, answers, Section::kAnswer, to.scope, response);
  const bool room = writer.complete();
  records_.write(writer, records_.additionals(answers, to.scope), Section::kAdditional, to.scope,
                 response);  // as many as fit
  return room ? std::optional(Datagram{.to = to, .bytes = writer.message()}) : std::nullopt;
}

std::optional<Responder::Datagram> Responder::step(const MdnsLink& link) noexcept {
  const bool probe = phase_ == Phase::kProbe;
  dns::Writer writer(
      buffer_, 0,
      probe ? std::uint16_t{0} : static_cast<std::uint16_t>(dns::kResponse | dns::kAuthoritative));
  if (probe) {
    records_.write_probe(writer, link.interface);
  } else if (phase_ == Phase::kAnnounce) {
    const RecordSet negative =
        records_.additionals(kSrv, link.interface) & kHostNsec;  // only where a kind is missing
    records_.write(writer, static_cast<RecordSet>((kAll & ~kHostNsec) | negative), Section::kAnswer,
                   link.interface, ResponseKind::kMulticast);
  } else {
    records_.write(writer, kLeaving, Section::kAnswer, link.interface, ResponseKind::kGoodbye);
  }
  return Datagram{.to = group_of(link.interface, link.ipv6), .bytes = writer.message()};
}

std::optional<Responder::Datagram> Responder::flush(MdnsLink& link, hal::Time now) noexcept {
  RecordSet answers = link.pending;
  link.pending = 0;
  link.more_from.reset();
  for (std::size_t bit = 0; bit < kRecordKinds; ++bit) {
    const RecordSet kind = static_cast<RecordSet>(answers & (1U << bit));
    if (kind != 0 && link.sent[bit] && now - *link.sent[bit] < kSecond) {
      answers = static_cast<RecordSet>(answers & ~kind);
    } else if (kind != 0) {
      link.sent[bit] = now;
    }
  }
  if (answers == 0) {
    return std::nullopt;
  }
  dns::Writer writer(buffer_, 0, dns::kResponse | dns::kAuthoritative);
  records_.write(writer, answers, Section::kAnswer, link.interface, ResponseKind::kMulticast);
  records_.write(writer, records_.additionals(answers, link.interface), Section::kAdditional,
                 link.interface, ResponseKind::kMulticast);
  return Datagram{.to = group_of(link.interface, link.ipv6), .bytes = writer.message()};
}

// Whoever claimed our name may be gone, or was nobody.
void Responder::take_back_name(hal::Time now) noexcept {
  if (phase_ == Phase::kSteady && suffix_ > 1 && now - conflicts_since_ >= kRenamed) {
    replacement_ = service_;
    enter(Phase::kGoodbye, now);
  }
}

std::optional<Responder::Datagram> Responder::next(hal::Time now) noexcept {
  take_back_name(now);
  while (phase_ != Phase::kSteady && phase_ != Phase::kStopped && now >= step_due_) {
    if (step_link_ < links_.all().size()) {
      return step(links_.all()[step_link_++]);
    }
    next_step(now);
  }
  for (MdnsLink& link : links_.all()) {
    if (link.pending != 0 && now >= link.due) {
      if (const std::optional<Datagram> datagram = flush(link, now)) {
        return datagram;
      }
    }
  }
  return std::nullopt;
}

}  // namespace stof::firmware
