// What datagrams say of sensors, also those that lie.
#include "host/discovery/found_sensors.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "firmware/wire/dns.h"
#include "firmware/wire/messages/announce.h"
#include "tests/support/random.h"

namespace stof::client {
namespace {

namespace dns = wire::dns;

std::vector<std::byte> announcement(const char* serial, std::uint16_t port = 7560,
                                    std::uint32_t request_id = 0, std::uint32_t session = 5) {
  wire::Announce announce{
      .request_id = request_id, .port = port, .subscribers = 1, .most_subscribers = 4};
  std::ranges::copy(std::string_view(serial), announce.serial.begin());
  announce.rate_millihertz = 30'000;
  wire::DatagramBuffer buffer;
  wire::encode_announce(announce, wire::payload_space(buffer).first<wire::kAnnounceBytes>());
  const auto packet = wire::seal_packet({.type = wire::PacketType::kAnnounce,
                                         .origin = {.device_id = 7, .session_id = session},
                                         .frame = {.health = wire::Health::kFault}},
                                        wire::kAnnounceBytes, buffer);
  return {packet.begin(), packet.end()};
}

std::vector<std::byte> mdns_answer() {
  std::array<std::byte, 512> space{};
  dns::Writer writer(space, 0, dns::kResponse);
  const dns::Name instance{"front (A17)", "_stof", "_udp", "local"};
  writer.begin_record({"_stof", "_udp", "local"}, dns::Type::kPtr, dns::kInternet, 4500);
  writer.data_name(instance);
  EXPECT_TRUE(writer.finish(dns::Writer::Section::kAnswer));
  writer.begin_record(instance, dns::Type::kSrv, dns::kInternet, 120);
  for (const int value : {0, 0, 7560}) {
    writer.data_u16(static_cast<std::uint16_t>(value));
  }
  writer.data_name({"stof-a17", "local"});
  EXPECT_TRUE(writer.finish(dns::Writer::Section::kAdditional));
  writer.begin_record(instance, dns::Type::kTxt, dns::kInternet, 4500);
  writer.data_text("serial", "A17");
  writer.data_text("name", "front");
  writer.data_text("id", "00000007");
  EXPECT_TRUE(writer.finish(dns::Writer::Section::kAdditional));
  const auto message = writer.message();
  return {message.begin(), message.end()};
}

TEST(FoundSensors, KnowsASensorByEveryWayAsOne) {
  FoundSensors found;
  found.take_mdns(mdns_answer(), "fe80::1%eth0");
  EXPECT_EQ(found.take_silent(), std::vector<std::string>{"[fe80::1%eth0]:7560"});
  found.take_mdns(mdns_answer(), "fe80::1%eth0");
  EXPECT_TRUE(found.take_silent().empty());
  EXPECT_FALSE(found.sorted()[0].health);
  EXPECT_TRUE(found.take_packet(announcement("A17"), "192.0.2.2", DiscoveryMethod::kBeacon));
  EXPECT_TRUE(found.take_packet(announcement("A17"), "192.0.2.3", DiscoveryMethod::kDirect));
  EXPECT_TRUE(found.take_packet(announcement("A17"), "192.0.2.4", DiscoveryMethod::kBeacon));
  const auto sensors = found.sorted();
  ASSERT_EQ(sensors.size(), 1U);
  EXPECT_EQ(sensors[0].endpoint(), "192.0.2.3:7560");  // of the surest method
  EXPECT_EQ(sensors[0].health, wire::Health::kFault);
  EXPECT_EQ(sensors[0].rate_millihertz, 30'000U);
  EXPECT_EQ(sensors[0].methods, (std::array{true, true, true}));
}

TEST(FoundSensors, OfTwoAddressesThatAnswerTakesTheOneThatAllProgramsTake) {
  FoundSensors found;
  EXPECT_TRUE(found.take_packet(announcement("A17"), "fe80::1%eth0", DiscoveryMethod::kDirect));
  EXPECT_TRUE(found.take_packet(announcement("A17"), "192.0.2.3", DiscoveryMethod::kDirect));
  EXPECT_TRUE(found.take_packet(announcement("A17"), "fe80::1%eth0", DiscoveryMethod::kDirect));
  EXPECT_EQ(found.sorted()[0].address, "192.0.2.3");
}

TEST(FoundSensors, TwoThatAnswerOneQuestionWithOneNumberAreTold) {
  FoundSensors found;
  const auto answer = [&found](std::uint32_t session, const char* from, std::uint32_t request = 9) {
    EXPECT_TRUE(found.take_packet(announcement("A17", 7560, request, session), from,
                                  DiscoveryMethod::kDirect));
  };
  found.begin_answers();
  answer(5, "192.0.2.3");
  answer(5, "fe80::1%eth0");
  found.begin_answers();
  answer(6, "192.0.2.3");  // it has started again
  answer(7, "192.0.2.3", 0);
  found.end_answers();
  answer(8, "192.0.2.3");
  ASSERT_EQ(found.sorted().size(), 1U);
  EXPECT_EQ(found.sorted()[0].rival, "");
  found.begin_answers();
  answer(8, "192.0.2.3");
  answer(9, "192.0.2.4");
  EXPECT_EQ(found.sorted()[0].address, "192.0.2.3");
  EXPECT_EQ(found.sorted()[0].rival, "192.0.2.4");
}

// Its beacon may come from an address that this machine does not reach, and IPv6 leads there.
TEST(FoundSensors, AsksEachAddressUntilOneAnswers) {
  FoundSensors found;
  EXPECT_TRUE(found.take_packet(announcement("A17"), "10.0.0.5", DiscoveryMethod::kBeacon));
  found.take_mdns(mdns_answer(), "fe80::1%eth0");
  EXPECT_TRUE(found.take_packet(announcement("A17"), "10.0.0.5", DiscoveryMethod::kBeacon));
  EXPECT_EQ(found.take_silent(),
            (std::vector<std::string>{"10.0.0.5:7560", "[fe80::1%eth0]:7560"}));
  EXPECT_TRUE(found.take_packet(announcement("A17"), "fe80::1%eth0", DiscoveryMethod::kDirect));
  EXPECT_TRUE(found.take_packet(announcement("A17"), "10.0.0.6", DiscoveryMethod::kBeacon));
  EXPECT_TRUE(found.take_silent().empty());
  EXPECT_EQ(found.sorted()[0].heard,
            (std::vector<std::string>{"10.0.0.5", "fe80::1%eth0", "10.0.0.6"}));
}

TEST(FoundSensors, KnowsWhoAnswersByBroadcastAlone) {
  FoundSensors found;
  // It has none; that is no place to ask at, since here it is this machine.
  EXPECT_TRUE(found.take_packet(announcement("A17"), "0.0.0.0", DiscoveryMethod::kBeacon));
  EXPECT_EQ(found.sorted()[0].address, kNoAddress);
  EXPECT_TRUE(found.sorted()[0].heard.empty());
  EXPECT_TRUE(found.take_silent().empty());
  EXPECT_TRUE(found.take_packet(announcement("A17"), "10.0.0.5", DiscoveryMethod::kBeacon));
  EXPECT_FALSE(found.sorted()[0].by_link_alone());  // that is a beacon, nothing was asked
  EXPECT_TRUE(
      found.take_packet(announcement("A17", 7560, 8), "10.0.0.5", DiscoveryMethod::kBeacon));
  EXPECT_TRUE(found.sorted()[0].by_link_alone());
  EXPECT_EQ(found.sorted()[0].address, "10.0.0.5");
  EXPECT_EQ(found.sorted()[0].session_id, 5U);
  EXPECT_TRUE(found.take_packet(announcement("A17"), "10.0.0.5", DiscoveryMethod::kDirect));
  EXPECT_FALSE(found.sorted()[0].by_link_alone());
}

TEST(FoundSensors, TellsSensorsApart) {
  FoundSensors found;
  for (const auto& packet :
       {announcement("B"), announcement("A"), announcement("A", 7570), announcement("A")}) {
    EXPECT_TRUE(found.take_packet(packet, "192.0.2.2", DiscoveryMethod::kBeacon));
  }
  const auto sensors = found.sorted();
  ASSERT_EQ(sensors.size(), 3U);
  EXPECT_EQ(sensors[0].serial + sensors[2].serial, "AB");
}

TEST(FoundSensors, KeepsATerminalSafe) {
  FoundSensors found;
  EXPECT_TRUE(found.take_packet(announcement("\x1b[2J\n"), "192.0.2.2", DiscoveryMethod::kBeacon));
  EXPECT_EQ(found.sorted()[0].serial, "?[2J?");
}

TEST(FoundSensors, BearsAnyBytes) {
  test::Random random(5);
  FoundSensors found;
  for (int round = 0; round < 10'000; ++round) {
    std::vector<std::byte> bytes = round % 2 == 0 ? mdns_answer() : announcement("A");
    bytes[static_cast<std::size_t>(random.between(0, static_cast<int>(bytes.size()) - 1))] =
        static_cast<std::byte>(random.next());
    bytes.resize(static_cast<std::size_t>(random.between(0, static_cast<int>(bytes.size()))));
    found.take_mdns(bytes, "192.0.2.2");
    static_cast<void>(found.take_silent());
    static_cast<void>(found.take_packet(bytes, "192.0.2.2", DiscoveryMethod::kBeacon));
  }
  EXPECT_LE(found.sorted().size(), 1000U);
}

TEST(FoundSensors, AFloodOfBeaconsLeavesWhoHasAnswered) {
  FoundSensors found;
  EXPECT_TRUE(found.take_packet(announcement("early"), "192.0.2.3", DiscoveryMethod::kDirect));
  for (std::uint16_t port = 1; port <= 3 * kMostFound; ++port) {
    EXPECT_TRUE(found.take_packet(announcement("B", port), "192.0.2.2", DiscoveryMethod::kBeacon));
    if (port == 2 * kMostFound) {
      EXPECT_TRUE(found.take_packet(announcement("late"), "192.0.2.4", DiscoveryMethod::kDirect));
    }
  }
  const std::vector<FoundSensor> sensors = found.sorted();
  EXPECT_EQ(sensors.size(), kMostFound);
  EXPECT_EQ(std::ranges::count(sensors, "early", &FoundSensor::serial), 1);
  EXPECT_EQ(std::ranges::count(sensors, "late", &FoundSensor::serial), 1);
}

TEST(FoundSensors, TwoNamesOfOneSensorAreKept) {
  FoundSensors found;
  found.take_mdns(mdns_answer(), "192.0.2.2");
  EXPECT_EQ(found.sorted()[0].other_name, "");
  EXPECT_TRUE(found.take_packet(announcement("A17"), "192.0.2.2", DiscoveryMethod::kDirect));
  EXPECT_EQ(found.sorted()[0].name, "");
  EXPECT_EQ(found.sorted()[0].other_name, "front");
}

}  // namespace
}  // namespace stof::client
