// What arrives: questions of others, and what they claim.
#include <algorithm>

#include "firmware/discovery/mdns.h"

namespace stof::firmware {
namespace {

namespace dns = wire::dns;
using namespace std::chrono_literals;
using Section = dns::Writer::Section;

// More than anybody asks or tells at once.
constexpr unsigned kMostQuestions = 32;
constexpr unsigned kMostRecords = 256;

// RFC 6762 section 6: answers that others may give as well come spread in time.
constexpr hal::Duration kLeastDelay = 20ms;
constexpr std::uint32_t kSpreadMs = 100;
constexpr hal::Duration kMoreDelay = 400ms;
constexpr hal::Duration kProbeGap = 250ms;

}  // namespace

std::optional<Responder::Datagram> Responder::take(std::span<const std::byte> message,
                                                   const hal::Peer& from, hal::Time now) noexcept {
  dns::Reader reader(message);
  const Result<dns::Header> header = reader.header();
  Link* const link = link_of(from);
  if (!header || (header->flags & dns::kOpcode) != 0 || link == nullptr || !on_link(from) ||
      from.port == 0 || phase_ == Phase::kStopped || phase_ == Phase::kGoodbye) {
    return std::nullopt;
  }
  if ((header->flags & dns::kResponse) == 0) {
    return take_query(reader, *header, from, *link, now);
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
    if (records_.rival(reader, *record) != Records::Rival::kNone) {
      lose(now);
      return;
    }
  }
}

// Two probe at the same time: the one whose data are greater goes on, the other waits a second and
// then finds the name taken.
void Responder::yield_probe(dns::Reader& reader, const dns::Header& header,
                            hal::Time now) noexcept {
  bool below = false;
  bool above = false;
  for (unsigned i = 0; i < std::min<unsigned>(header.authorities, kMostRecords); ++i) {
    const Result<dns::Record> record = reader.record();
    if (!record) {
      return;
    }
    const Records::Rival rival = records_.rival(reader, *record);
    below = below || rival == Records::Rival::kBelow;
    above = above || rival == Records::Rival::kAbove;
  }
  if (above && !below) {
    enter(Phase::kProbe, now + 1s);
  }
}

std::optional<Responder::Datagram> Responder::take_query(dns::Reader& reader,
                                                         const dns::Header& header,
                                                         const hal::Peer& from, Link& link,
                                                         hal::Time now) noexcept {
  const bool legacy = from.port != kPort;
  const bool probe = header.authorities > 0;
  RecordSet alone = 0;
  RecordSet all = 0;
  std::optional<dns::Question> first;
  if (header.questions > kMostQuestions || header.answers > kMostRecords) {
    return std::nullopt;
  }
  for (unsigned i = 0; i < header.questions; ++i) {
    const Result<dns::Question> question = reader.question();
    if (!question) {
      return std::nullopt;
    }
    const RecordSet answers = records_.answers(*question, link.interface);
    const bool unicast = legacy || (question->klass & dns::kTopBit) != 0;
    (unicast ? alone : all) |= answers;
    if (answers != 0 && !first) {
      first = *question;
    }
  }
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
      yield_probe(reader, header, now);
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
  if (all != 0) {
    const bool more = (header.flags & dns::kTruncated) != 0;
    hal::Duration delay{};
    if (!probe && (more || (all & kShared) != 0)) {
      delay = (more ? kMoreDelay : kLeastDelay) + std::chrono::milliseconds(random(kSpreadMs));
    }
    schedule(link, all, now + delay);
    link.more_from = more ? std::optional(from) : std::nullopt;
  }
  return alone == 0 ? std::nullopt
                    : answer_alone(legacy ? std::span(&*first, 1) : std::span<dns::Question>{},
                                   alone, legacy ? header.id : std::uint16_t{0}, from);
}

void Responder::schedule(Link& link, RecordSet answers, hal::Time due) noexcept {
  link.due = link.pending == 0 ? due : std::min(link.due, due);
  link.pending |= answers;
}

std::optional<Responder::Datagram> Responder::answer_alone(std::span<const dns::Question> questions,
                                                           RecordSet answers, std::uint16_t id,
                                                           const hal::Peer& to) noexcept {
  const Tone tone = questions.empty() ? Tone::kMulticast : Tone::kLegacy;
  dns::Writer writer(buffer_, id, dns::kResponse | dns::kAuthoritative);
  for (const dns::Question& question : questions) {
    static_cast<void>(writer.question(question.name, question.type, dns::kInternet));
  }
  records_.write(writer, answers, Section::kAnswer, to.scope, tone);
  records_.write(writer, records_.additionals(answers, to.scope), Section::kAdditional, to.scope,
                 tone);
  return Datagram{.to = to, .bytes = writer.message()};
}

}  // namespace stof::firmware
