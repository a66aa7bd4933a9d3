// The multicast DNS responder: what RFC 6762 and 6763 ask of it.
#include <gtest/gtest.h>

#include "tests/firmware/discovery/mdns_support.h"
#include "tests/support/random.h"

namespace stof::firmware::test {
namespace {

using namespace std::chrono_literals;

std::string text_of_bytes(const std::vector<std::byte>& bytes) {
  std::string out;
  for (const std::byte byte : bytes) {
    const int value = std::to_integer<int>(byte);
    out += value >= 0x20 && value < 0x7f ? static_cast<char>(value) : '.';
  }
  return out;
}

TEST(Responder, ProbesThreeTimesAndAnnouncesTwice) {
  Bench bench;
  const auto heard = bench.run(4s);
  ASSERT_EQ(heard.size(), 5U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(heard[i].header.flags, 0);
    ASSERT_EQ(heard[i].questions.size(), 2U);
    EXPECT_EQ(heard[i].questions[0].name, kInstance);
    EXPECT_EQ(heard[i].questions[1].name, kHost);
    EXPECT_EQ(heard[i].header.authorities, 2);  // SRV, A
  }
  for (std::size_t i = 3; i < 5; ++i) {
    EXPECT_EQ(heard[i].header.flags, 0x8400);
    EXPECT_EQ(heard[i].header.questions, 0);
    EXPECT_EQ(heard[i].count(Type::kPtr), 2);
    EXPECT_EQ(heard[i].count(Type::kSrv), 1);
    EXPECT_EQ(heard[i].count(Type::kTxt), 1);
    EXPECT_EQ(heard[i].count(Type::kA), 1);
  }
  EXPECT_EQ(heard[1].at - heard[0].at, 250ms);
  EXPECT_EQ(heard[3].at - heard[2].at, 250ms);
  EXPECT_EQ(heard[4].at - heard[3].at, 1s);
  for (const Heard& one : heard) {
    EXPECT_EQ(one.to.address, hal::from_ipv4(224, 0, 0, 251));
    EXPECT_EQ(one.to.port, 5353);
    EXPECT_EQ(one.to.scope, kEthernet);
  }
  EXPECT_TRUE(bench.responder.established());
}

TEST(Responder, AnswersForTheServiceWithAllThatIsNeededToConnect) {
  Bench bench;
  bench.settle();
  EXPECT_FALSE(bench.take(Message().ask(kService, Type::kPtr).bytes()));
  const hal::Time asked = bench.now;
  const auto heard = bench.run(1s);
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_GE(heard[0].at - asked, 20ms);
  EXPECT_LE(heard[0].at - asked, 130ms);
  EXPECT_EQ(heard[0].header.answers, 1);
  const dns::Record* const pointer = heard[0].find(Type::kPtr);
  ASSERT_NE(pointer, nullptr);
  EXPECT_EQ(pointer->klass, 1);  // others have it, too
  EXPECT_EQ(pointer->ttl_s, 4500U);
  EXPECT_EQ(*dns::Reader(heard[0].bytes).name_at(pointer->data_offset), kInstance);
  const dns::Record* const srv = heard[0].find(Type::kSrv);
  ASSERT_NE(srv, nullptr);
  EXPECT_EQ(srv->klass, 0x8001);
  EXPECT_EQ(srv->ttl_s, 120U);
  EXPECT_EQ(srv->data[5], std::byte{7560 & 0xff});
  EXPECT_EQ(*dns::Reader(heard[0].bytes).name_at(srv->data_offset + 6), kHost);
  EXPECT_EQ(heard[0].count(Type::kA), 1);
  EXPECT_EQ(heard[0].count(Type::kNsec), 1);  // no AAAA
  const std::string text = text_of_bytes(heard[0].bytes);
  for (const char* const entry : {"txtvers=1", "serial=A17", "name=front", "version=0.1.0",
                                  "board=emu", "id=0a0b0c0d", "path=/"}) {
    EXPECT_NE(text.find(entry), std::string::npos) << entry;
  }
}

// Written out by hand from RFC 1035 and RFC 6762.
TEST(Responder, AnswersAnAddressInTheseBytes) {
  Bench bench;
  bench.settle();
  const auto answer = bench.take(Message(0, 0x1234).ask(kHost, Type::kA).bytes(70), kLegacyPeer);
  ASSERT_TRUE(answer);
  const std::vector<int> expected{
      0x12, 0x34, 0x84, 0x00, 0,   1,   0,   1,   0,   0,  0,   1,                       // header
      8,    's',  't',  'o',  'f', '-', 'a', '1', '7', 5,  'l', 'o', 'c',  'a', 'l',     // question
      0,    0,    1,    0,    1,                                                         //
      0xc0, 12,   0,    1,    0,   1,   0,   0,   0,   10, 0,   4,   192,  0,   2,   2,  // A
      0xc0, 12,   0,    47,   0,   1,   0,   0,   0,   10, 0,   8,   0xc0, 12,  0,   4,
      0x40, 0,    0,    0};  // NSEC
  std::vector<std::byte> bytes(std::size(expected));
  std::ranges::transform(expected, bytes.begin(),
                         [](int value) { return static_cast<std::byte>(value); });
  EXPECT_EQ(answer->bytes, bytes);
  EXPECT_EQ(answer->to, kLegacyPeer);
}

TEST(Responder, AnswersAloneWhoAsksForIt) {
  Bench bench;
  bench.settle();
  const auto answer =
      bench.take(Message(0, 9).ask(kInstance, Type::kSrv, 0x8001).bytes(512), kNeighbour);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->to, kNeighbour);
  EXPECT_EQ(answer->header.id, 0);
  EXPECT_EQ(answer->header.questions, 0);
  EXPECT_EQ(answer->find(Type::kSrv)->ttl_s, 120U);
  EXPECT_TRUE(bench.run(1s).empty());
}

TEST(Responder, SaysThatATypeIsMissing) {
  Bench bench;
  bench.settle();
  EXPECT_FALSE(bench.take(Message().ask(kHost, Type::kAaaa).bytes()));
  const auto heard = bench.run(1s);
  ASSERT_EQ(heard.size(), 1U);
  const dns::Record* const nsec = heard[0].find(Type::kNsec);
  ASSERT_NE(nsec, nullptr);
  EXPECT_EQ(nsec->data.back(), std::byte{0});  // of AAAA
}

TEST(Responder, KeepsSilentAboutWhatIsKnown) {
  Bench bench;
  bench.settle();
  static_cast<void>(
      bench.take(Message().ask(kService, Type::kPtr).pointer(kService, kInstance, 2250).bytes()));
  EXPECT_TRUE(bench.run(1s).empty());
  // With less than half of its life left it is told again.
  static_cast<void>(
      bench.take(Message().ask(kService, Type::kPtr).pointer(kService, kInstance, 2249).bytes()));
  EXPECT_EQ(bench.run(1s).size(), 1U);
}

TEST(Responder, WaitsForKnownAnswersThatFollow) {
  Bench bench;
  bench.settle();
  static_cast<void>(bench.take(Message(dns::kTruncated).ask(kService, Type::kPtr).bytes()));
  EXPECT_TRUE(bench.run(300ms).empty());
  static_cast<void>(bench.take(Message().pointer(kService, kInstance, 4500).bytes()));
  EXPECT_TRUE(bench.run(1s).empty());
}

TEST(Responder, TellsAllTheSameOnceASecondAtMost) {
  Bench bench;
  bench.settle();
  int heard = 0;
  for (int i = 0; i < 30; ++i) {
    static_cast<void>(bench.take(Message().ask(kInstance, Type::kTxt).bytes()));
    heard += static_cast<int>(bench.run(100ms).size());
  }
  EXPECT_EQ(heard, 3);
}

TEST(Responder, AnswersNobodyBeyondItsLink) {
  Bench bench;
  bench.settle();
  const auto question = Message().ask(kService, Type::kPtr, 0x8001).bytes(512);
  hal::Peer stranger = kLegacyPeer;
  stranger.address = hal::from_ipv4(198, 51, 100, 1);
  EXPECT_FALSE(bench.take(question, stranger));
  hal::Peer elsewhere = kLegacyPeer;
  elsewhere.scope = 3;
  EXPECT_FALSE(bench.take(question, elsewhere));
  EXPECT_TRUE(bench.take(question, kLegacyPeer));
}

// Whoever writes a victim's address on its questions gets nothing larger sent there.
TEST(Responder, AnswersAloneWithNoMoreThanItWasAsked) {
  Bench bench;
  bench.settle();
  int answers = 0;
  for (const auto& [name, type] : {std::pair(kService, Type::kPtr),
                                   {kServices, Type::kPtr},
                                   {kInstance, Type::kAny},
                                   {kInstance, Type::kTxt},
                                   {kHost, Type::kA},
                                   {kHost, Type::kAaaa}}) {
    for (std::size_t bytes = 0; bytes < 700; ++bytes) {
      bench.now += 20ms;
      const auto question = Message().ask(name, type, 0x8001).bytes(bytes);
      for (const hal::Peer& peer : {kLegacyPeer, kNeighbour}) {
        if (const auto answer = bench.take(question, peer)) {
          EXPECT_LE(answer->bytes.size(), question.size());
          EXPECT_GE(answer->header.answers, 1);
          ++answers;
        }
      }
    }
  }
  EXPECT_GT(answers, 1000);
  // Who speaks multicast DNS gets the answer there, with everybody else.
  static_cast<void>(bench.run(2s));
  EXPECT_FALSE(bench.take(Message().ask(kInstance, Type::kSrv, 0x8001).bytes()));
  EXPECT_EQ(bench.run(1s).size(), 1U);
  EXPECT_FALSE(bench.take(Message().ask(kInstance, Type::kSrv).bytes(), kLegacyPeer));
  EXPECT_TRUE(bench.run(1s).empty());
}

TEST(Responder, AnswersAloneFiftyTimesASecond) {
  Bench bench;
  bench.settle();
  const auto question = Message().ask(kHost, Type::kA).bytes(512);
  int answers = 0;
  for (int i = 0; i < 10'000; ++i) {  // two seconds
    bench.now += 200us;
    answers += bench.take(question, kLegacyPeer) ? 1 : 0;
  }
  EXPECT_LE(answers, 3 * static_cast<int>(Responder::kAlonePerSecond));
  EXPECT_GE(answers, 2 * static_cast<int>(Responder::kAlonePerSecond));
}

TEST(Responder, TakesItsNameBackWhenNobodyHasClaimedItForLong) {
  Bench bench;
  static_cast<void>(bench.run(300ms));
  static_cast<void>(bench.take(Message(0x8400).address(kHost, kPeer4).bytes()));  // forged
  bench.settle();
  ASSERT_EQ(bench.responder.host(), (dns::Name{"stof-a17-2", "local"}));
  static_cast<void>(bench.run(Responder::kRenamed - 10s));
  EXPECT_EQ(bench.responder.host(), (dns::Name{"stof-a17-2", "local"}));
  static_cast<void>(bench.run(20s));
  EXPECT_EQ(bench.responder.host(), kHost);
  EXPECT_TRUE(bench.responder.established());
  static_cast<void>(bench.run(2 * Responder::kRenamed));
  EXPECT_EQ(bench.responder.host(), kHost);
}

TEST(Responder, TakesAnotherNameWhereItsOwnIsTaken) {
  Bench bench;
  static_cast<void>(bench.run(300ms));
  static_cast<void>(bench.take(Message(0x8400).srv(kInstance, 7560, {"other", "local"}).bytes()));
  const auto heard = bench.run(4s);
  EXPECT_EQ(bench.responder.instance(), (dns::Name{"front (A17)-2", "_stof", "_udp", "local"}));
  EXPECT_EQ(bench.responder.host(), (dns::Name{"stof-a17-2", "local"}));
  ASSERT_EQ(heard.size(), 5U);  // probes and announces anew
  EXPECT_TRUE(bench.responder.established());
}

TEST(Responder, ProbesAgainBeforeItGivesUpANameThatItHas) {
  Bench bench;
  bench.settle();
  const auto claim = Message(0x8400).address(kHost, kPeer4).bytes();
  static_cast<void>(bench.take(claim));
  EXPECT_EQ(bench.responder.host(), kHost);
  EXPECT_FALSE(bench.responder.established());
  static_cast<void>(bench.run(300ms));
  static_cast<void>(bench.take(claim));  // the other one insists
  EXPECT_EQ(bench.responder.host(), (dns::Name{"stof-a17-2", "local"}));
}

TEST(Responder, TakesItsOwnWordsForNoRivals) {
  Bench bench;
  for (int i = 0; i < 400; ++i) {
    bench.now += 10ms;
    while (const auto datagram = bench.responder.next(bench.now)) {
      const std::vector<std::byte> copy(datagram->bytes.begin(), datagram->bytes.end());
      EXPECT_FALSE(bench.take(copy, {.address = kOwn4, .port = 5353, .scope = kEthernet}));
    }
  }
  EXPECT_EQ(bench.responder.instance(), kInstance);
  EXPECT_TRUE(bench.responder.established());
}

// Two that begin at once: one of them keeps the name.
TEST(Responder, AgreesWithATwinOnWhoIsCalledWhat) {
  for (const int offset_ms : {0, 40, 120, 250, 400, 900}) {
    Bench one;
    hal::InterfaceAddress other_address = kEthernet4;
    other_address.address = kPeer4;
    Bench other({other_address});
    other.now += std::chrono::milliseconds(offset_ms);
    other.responder.set_addresses({}, other.now);
    other.responder.set_addresses(std::span(&other_address, 1), other.now);
    for (hal::Time now = one.now; now < one.now + 20s; now += 5ms) {
      while (const auto datagram = one.responder.next(now)) {
        const std::vector<std::byte> copy(datagram->bytes.begin(), datagram->bytes.end());
        static_cast<void>(
            other.responder.take(copy, {.address = kOwn4, .port = 5353, .scope = kEthernet}, now));
      }
      while (const auto datagram = other.responder.next(now)) {
        const std::vector<std::byte> copy(datagram->bytes.begin(), datagram->bytes.end());
        static_cast<void>(
            one.responder.take(copy, {.address = kPeer4, .port = 5353, .scope = kEthernet}, now));
      }
    }
    EXPECT_TRUE(one.responder.established()) << offset_ms;
    EXPECT_TRUE(other.responder.established()) << offset_ms;
    EXPECT_NE(one.responder.host() == other.responder.host(), true) << offset_ms;
    EXPECT_TRUE(one.responder.host() == kHost || other.responder.host() == kHost) << offset_ms;
  }
}

// RFC 6762 section 8.2: of two that probe at once the one with the greater data goes on.
TEST(Responder, YieldsToTheProbeWithTheGreaterAddress) {
  for (const std::uint8_t last : {std::uint8_t{1}, std::uint8_t{9}}) {
    Bench bench;
    EXPECT_FALSE(bench.run(300ms).empty());
    const auto probe =
        Message()
            .ask(kHost, Type::kAny)
            .address(kHost, hal::from_ipv4(192, 0, 2, last), dns::Writer::Section::kAuthority)
            .bytes();
    EXPECT_FALSE(bench.take(probe));
    EXPECT_EQ(bench.run(900ms).empty(), last == 9) << int{last};
    EXPECT_EQ(bench.responder.host(), kHost);
  }
}

TEST(Responder, SaysGoodbye) {
  Bench bench;
  bench.settle();
  bench.responder.stop(bench.now);
  const auto heard = bench.run(3s);
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].count(Type::kPtr), 1);  // the list of services is not ours alone
  for (const dns::Record& record : heard[0].records) {
    EXPECT_EQ(record.ttl_s, 0U);
  }
}

TEST(Responder, LeavesItsOldNameWhenItIsRenamed) {
  Bench bench;
  bench.settle();
  Service renamed = some_service();
  renamed.announce.name = {'a', 'f', 't'};
  bench.responder.set_service(renamed, bench.now);
  const auto heard = bench.run(4s);
  ASSERT_EQ(heard.size(), 6U);
  EXPECT_EQ(heard[0].records[0].ttl_s, 0U);
  EXPECT_EQ(bench.responder.instance(), (dns::Name{"aft (A17)", "_stof", "_udp", "local"}));
}

TEST(Responder, SpeaksOnEveryLinkWithTheAddressesOfThat) {
  hal::InterfaceAddress wireless = kEthernet4;
  wireless.interface = 3;
  wireless.address = hal::from_ipv4(10, 0, 0, 1);
  hal::InterfaceAddress local6 = kEthernet4;
  local6.address = {0xfe, 0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  local6.prefix_bits = 64;
  const hal::InterfaceAddress loopback{.interface = 1, .address = hal::from_ipv4(127, 0, 0, 1)};
  Bench bench({loopback, kEthernet4, wireless, local6});
  const auto heard = bench.run(4s);
  ASSERT_EQ(heard.size(), 15U);
  for (const Heard& one : heard) {
    EXPECT_EQ(one.count(Type::kA), 1);
    EXPECT_EQ(one.count(Type::kAaaa), one.to.scope == kEthernet ? 1 : 0);
    EXPECT_EQ(one.find(Type::kA)->data[0], one.to.scope == 3 ? std::byte{10} : std::byte{192});
  }
}

TEST(Responder, BeginsAnewWhenItsAddressesChange) {
  Bench bench(std::vector<hal::InterfaceAddress>{});
  EXPECT_TRUE(bench.run(3s).empty());
  bench.responder.set_addresses(std::span(&kEthernet4, 1), bench.now);
  EXPECT_EQ(bench.run(4s).size(), 5U);
  bench.responder.set_addresses(std::span(&kEthernet4, 1), bench.now);
  EXPECT_TRUE(bench.run(4s).empty());
}

TEST(Responder, BearsAnyBytes) {
  Bench bench;
  bench.settle();
  const auto good = Message()
                        .ask(kService, Type::kPtr, 0x8001)
                        .ask(kHost, Type::kAny)
                        .pointer(kService, kInstance, 4500)
                        .srv(kInstance, 1, kHost)
                        .bytes();
  stof::test::Random random(3);
  for (int round = 0; round < 20'000; ++round) {
    std::vector<std::byte> damaged = good;
    for (int i = 0; i < 1 + round % 5; ++i) {
      damaged[static_cast<std::size_t>(random.between(0, static_cast<int>(good.size()) - 1))] =
          static_cast<std::byte>(random.next());
    }
    damaged.resize(static_cast<std::size_t>(random.between(0, static_cast<int>(good.size()))));
    static_cast<void>(bench.take(damaged, round % 2 == 0 ? kNeighbour : kLegacyPeer));
    if (round % 64 == 0) {
      static_cast<void>(bench.run(10ms));
    }
  }
  // A name that is contested for ever is not looked for ever faster.
  bench.settle();
  bench.settle();
  EXPECT_TRUE(bench.responder.established());
}

}  // namespace
}  // namespace stof::firmware::test
