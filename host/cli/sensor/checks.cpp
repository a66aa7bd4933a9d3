#include "host/cli/sensor/checks.h"

#include <algorithm>
#include <array>

#include "firmware/wire/messages/conditions.h"
#include "firmware/wire/packet.h"
#include "host/cli/live/link_teller.h"
#include "host/cli/receive.h"
#include "host/cli/recording/damage_text.h"
#include "host/cli/recording/file_state.h"
#include "host/cli/sensor_text.h"
#include "host/client/sensor_socket.h"
#include "host/client/value_names.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::array kVerdictNames{"ok", "note", "fix"};
constexpr int kIpAndUdp = 48;  // bytes of the headers, of IPv6
constexpr int kLeastMtu = static_cast<int>(wire::kMaxDatagram) + kIpAndUdp;

bool has_condition(const CheckFacts& facts, wire::Condition condition) {
  return facts.health &&
         ((facts.health->report.active >> static_cast<unsigned>(condition)) & 1U) != 0;
}

// What is asked of a sensor is not asked of who plays a recording of it.
bool is_played(const CheckFacts& facts) { return facts.clock == wire::ClockState::kRecorded; }
std::string sensor_of(const CheckFacts& facts) {
  return facts.recorded || is_played(facts) ? "SENSOR" : facts.sensor;
}

// Of the sensor, where its place names one: "UDP 192.168.1.20:7800".
std::string port_of(const CheckFacts& facts) {
  const std::string& place = facts.stats.source;
  const std::size_t colon = place.rfind(':');
  return colon == std::string::npos ? std::to_string(client::kDefaultPort)
                                    : place.substr(colon + 1);
}

// It sent, and sends no more.
Check check_ended(const CheckFacts& facts) {
  Check check{.name = "reach", .verdict = CheckVerdict::kFix};
  const std::string since = printed("%llu frames came, the last one %s ago; ",
                                    static_cast<unsigned long long>(facts.stats.figures.frames()),
                                    age_text(facts.silent_since).c_str());
  if (facts.comes == Comes::kHealthAlone) {
    check.found = since + "since then its health alone comes";
    check.fix = "see health";
  } else if (is_played(facts)) {
    check.verdict = CheckVerdict::kNote;
    check.found = since + "a recording was played, which is over";
    check.fix = "play it again: stof replay FILE --loop";
  } else {
    check.found = since + (facts.nobody_listens ? "it was stopped: nobody listens there any more"
                                                : "nothing comes any more");
    check.fix =
        "start it again, or check its power and cable: stof discover lists the sensors near";
  }
  return check;
}

Check check_reach(const CheckFacts& facts) {
  Check check{.name = "reach"};
  if (facts.stats.figures.frames() != 0 && facts.comes != Comes::kFrames) {
    return check_ended(facts);
  }
  if (facts.stats.figures.frames() != 0) {
    check.found = facts.stats.source + " sends" +
                  (facts.identity ? ", serial " + facts.identity->serial + ", version " +
                                        facts.identity->version
                                  : "");
    return check;
  }
  check.verdict = CheckVerdict::kFix;
  if (facts.nobody_listens) {
    check.found = "its computer answers, and nobody listens there";
    check.fix = "start stofd, or name its port: stof discover lists it";
  } else if (facts.all_places_taken) {
    check.found = std::string("it has as many subscribers as it takes: ") + kPlacesText;
    check.fix = "end another one: stof discover says how many there are";
  } else if (facts.comes == Comes::kHealthAlone) {
    check.found = "its health comes, and no frame";
    check.fix = "see health";
  } else if (facts.identity) {
    check.found = "it answers, and no frame comes";
    check.fix = "stof health " + facts.sensor + " says why, or see firewall";
  } else {
    check.found = "no answer";
    check.fix = "check power, cable and address: stof discover lists the sensors near";
  }
  return check;
}

Check check_firewall(const CheckFacts& facts) {
  Check check{.name = "firewall"};
  const std::string port = port_of(facts);
  if (facts.sending_refused) {
    check.verdict = CheckVerdict::kFix;
    check.found = "this machine's own firewall refuses to send there";
    check.fix = "allow UDP out to port " + port + ": nft add rule inet filter output udp dport " +
                port + " accept";
  } else if (facts.stats.figures.frames() == 0 && facts.nobody_listens) {
    check.found = "requests pass, and an answer: that nobody listens there";
  } else if (facts.stats.figures.frames() == 0 && facts.comes == Comes::kHealthAlone) {
    check.found = "requests pass, and what the sensor sends: its health";
  } else if (facts.stats.figures.frames() == 0 && facts.subscribed) {
    check.verdict = CheckVerdict::kFix;
    check.found = "the sensor took the subscription, and its stream does not arrive";
    check.fix = "allow UDP in from port " + port + ": nft add rule inet filter input udp sport " +
                port + " accept";
  } else if (facts.stats.figures.frames() == 0) {
    check.verdict = CheckVerdict::kNote;
    check.found = "nothing arrives: it may be a firewall on the way";
    check.fix = "allow UDP port " + port + " both ways, and try again";
  } else if (facts.comes == Comes::kNothing) {
    check.found = "requests and stream passed, while it sent";
  } else if (!facts.network.loopback && !facts.beacon_heard) {
    check.verdict = CheckVerdict::kNote;
    check.found =
        "the stream passes; the beacon (UDP 7561) is not heard, so stof discover may "
        "not list it";
    check.fix =
        "allow UDP in to port 7561: nft add rule inet filter input udp dport 7561 accept; "
        "behind a router there is none";
  } else {
    check.found = "requests, stream and beacon pass";
  }
  return check;
}

Check check_mtu(const CheckFacts& facts) {
  Check check{.name = "mtu"};
  const std::string device = facts.network.interface;
  if (!facts.network.mtu) {
    check.verdict = CheckVerdict::kNote;
    check.found = "the system does not tell which interface leads there";
  } else if (*facts.network.mtu < kLeastMtu) {
    check.verdict = CheckVerdict::kFix;
    check.found = printed("%d bytes by %s, packets have up to %d", *facts.network.mtu,
                          device.c_str(), kLeastMtu);
    check.fix = "ip link set dev " + device + " mtu 1500";
  } else {
    check.found =
        printed("%d bytes by %s, %d needed", *facts.network.mtu, device.c_str(), kLeastMtu);
  }
  return check;
}

Check check_buffers(const CheckFacts& facts) {
  Check check{.name = "buffers"};
  check.found =
      printed("%d of %d bytes granted, %llu datagrams found them full", facts.buffer,
              facts.asked_buffer, static_cast<unsigned long long>(facts.stats.counts.socket_drops));
  if (facts.buffer < facts.asked_buffer) {
    check.verdict = CheckVerdict::kFix;
    check.fix = printed("sysctl -w net.core.rmem_max=%d (board/systemd/60-stof.conf keeps it)",
                        facts.asked_buffer);
  } else if (facts.stats.counts.socket_drops != 0) {
    check.verdict = CheckVerdict::kFix;
    check.fix = "this computer is too slow for its work: fewer programs, or fewer streams";
  }
  return check;
}

constexpr double kTolerable = 0.01;  // of the frames

// Frames came late, all of them.
std::string silence_fix(const CheckFacts& facts) {
  return "the sensor, the network or this computer stood still; stof health " + sensor_of(facts) +
         " tells of the sensor, and radio may stand still for moments";
}

// share: of the frames that were lost.
std::string loss_fix(const CheckFacts& facts, double share) {
  const client::Statistics& counts = facts.stats.counts;
  const bool some_lost = counts.frames_lost + counts.frames_incomplete != 0;
  if (some_lost && facts.stats.damage.value_or(Damage{}).records != 0) {
    return "what is damaged in the file counts as lost: see file";
  }
  if (counts.socket_drops != 0) {
    return "see buffers";
  }
  if (counts.bad_crc + counts.truncated != 0) {
    return "packets are damaged on the way: another cable, another switch port";
  }
  if (!some_lost) {
    return "no frame was lost on the way: " + silence_fix(facts);
  }
  if (facts.stats.silences != 0 && share <= kTolerable) {
    return "few frames were lost, silence is what counts: " + silence_fix(facts);
  }
  return "stof config " + sensor_of(facts) +
         " set streams.parity=true mends single losses; a cable in place of radio, or fewer "
         "streams (streams.*=off)" +
         (facts.stats.silences == 0 ? "" : "; of the silence: " + silence_fix(facts));
}

// Of a recording: nothing but what is sound in it is looked at.
Check check_file(const CheckFacts& facts) {
  Check check{.name = "file", .found = "no record of it is damaged"};
  if (const Damage damage = facts.stats.damage.value_or(Damage{}); damage.records != 0) {
    check.verdict = CheckVerdict::kFix;
    check.found = damage_text(damage.records, damage.bytes);
    check.fix = "stof recover FILE OUT writes what is sound";
  } else if (damage.state.end != mcap::StreamReader::End::kWhole) {
    check.verdict = CheckVerdict::kNote;
    check.found = damage.state.being_written
                      ? "another program writes it: it is not whole yet"
                      : "it was cut: what came behind its last whole record is not there";
    check.fix = damage.state.being_written ? "" : "stof recover FILE gives it its index";
  } else if (!damage.state.indexed) {
    check.verdict = CheckVerdict::kNote;
    check.found = "its index is damaged, and no other record";
    check.fix = "stof recover FILE writes it anew";
  }
  if (const recording::FileState& state = facts.stats.damage.value_or(Damage{}).state;
      state.files > 1) {
    check.found += "; " + files_text(state);
  }
  return check;
}

Check check_link(const CheckFacts& facts) {
  Check check{.name = "link"};
  const client::Statistics& counts = facts.stats.counts;
  const StreamFigures& figures = facts.stats.figures;
  const double lost = static_cast<double>(counts.frames_lost + counts.frames_incomplete);
  const double all = lost + static_cast<double>(counts.frames_complete);
  const double share = all > 0 ? lost / all : 1;
  check.found = printed("%.0f of %.0f frames lost or not whole", lost, all) +
                (figures.rate_hz() ? printed(", %.1f frames a second", *figures.rate_hz()) : "") +
                (facts.stats.silences != 0 ? printed(", %u %s silent", facts.stats.silences,
                                                     facts.stats.silences == 1 ? "time" : "times")
                                           : "");
  if (lost > 0 || facts.stats.silences != 0) {
    check.verdict =
        share > kTolerable || facts.stats.silences != 0 ? CheckVerdict::kFix : CheckVerdict::kNote;
    check.fix = loss_fix(facts, share);
  }
  if (facts.forged_traffic) {  // whatever else: nothing is sure then
    check.verdict = CheckVerdict::kFix;
    check.found += facts.recorded ? ", and somebody spoke in the sensor's name, or it was faulty"
                                  : ", and somebody speaks in the sensor's name, or it is faulty";
    check.fix = facts.recorded ? "record it anew, with --signed"
                               : "find who it is; stof pair, and --signed, is spared him";
  }
  if (facts.network.speed_mbit && figures.seconds() > 0) {
    constexpr double kMostShare = 0.7;
    const double mbit =
        8e-6 * kLeastMtu * static_cast<double>(counts.packets()) / figures.seconds();
    check.found += printed(", at most %.0f of %d Mbit/s", mbit, *facts.network.speed_mbit);
    if (mbit > kMostShare * *facts.network.speed_mbit) {
      check.verdict = CheckVerdict::kFix;
      check.fix = "the link is nearly full: Gigabit, or fewer streams";
    }
  }
  return check;
}

Check check_clock(const CheckFacts& facts) {
  Check check{.name = "clock",
              .found = std::string("the sensor's is ") + client::clock_text(facts.clock)};
  if (facts.stats.figures.stamps_back() != 0) {
    check.verdict = CheckVerdict::kFix;
    check.found += printed(", %llu stamps go back",
                           static_cast<unsigned long long>(facts.stats.figures.stamps_back()));
    check.fix =
        "two senders share one number, or the sensor is faulty: stof discover, then stofd "
        "--device";
  } else if (facts.clock == wire::ClockState::kRecorded) {
    check.verdict = CheckVerdict::kNote;
    check.found += ": nothing of it is new";
  } else if (!facts.recorded && facts.network.clock_synchronised == false) {
    check.verdict = CheckVerdict::kNote;
    check.found += "; this computer's own is not synchronised, so times of recordings may be off";
    check.fix = "timedatectl set-ntp true";
  }
  return check;
}

Check check_calibration(const CheckFacts& facts) {
  Check check{.name = "calibration"};
  if (facts.lenses_contradict) {
    check.verdict = CheckVerdict::kFix;
    check.found = lenses_contradict_text();
    check.fix = "record it anew, with --signed";
  } else if (!facts.calibration) {
    check.verdict = CheckVerdict::kFix;
    check.found = "none came";
    check.fix = "clouds take one: stof calib install FILE " + sensor_of(facts);
  } else if (facts.other_calibration) {
    check.verdict = CheckVerdict::kFix;
    check.found = "frames are of another one than the sensor tells";
    check.fix = "wait a second and check again, else restart the sensor";
  } else if (!facts.drift.empty() || has_condition(facts, wire::Condition::kDrift)) {
    check.verdict = CheckVerdict::kFix;
    check.found = facts.drift.empty() ? "the rig has drifted from it" : facts.drift.substr(2);
    check.fix = "calibrate it anew: docs/CALIBRATION.md";
  } else if (has_condition(facts, wire::Condition::kCalibrationDropped)) {
    check.verdict = CheckVerdict::kFix;
    check.found = "the installed one could not be used at the start: the factory's holds";
    check.fix = "stof calib install FILE " + sensor_of(facts);
  } else if (facts.frames_without_lens != 0) {
    check.verdict = CheckVerdict::kNote;
    check.found = printed(
        "fingerprint %08x; %llu of %llu frames have none: it had not come, or "
        "another one contradicted it",
        facts.calibration->fingerprint, static_cast<unsigned long long>(facts.frames_without_lens),
        static_cast<unsigned long long>(facts.stats.counts.frames_complete +
                                        facts.stats.counts.frames_incomplete));
  } else {
    check.found = printed("fingerprint %08x, no drift told", facts.calibration->fingerprint);
  }
  return check;
}

Check check_health(const CheckFacts& facts) {
  Check check{.name = "health"};
  if (!facts.health) {
    check.verdict = CheckVerdict::kNote;
    check.found = "none came";
    return check;
  }
  const wire::HealthReport& report = facts.health->report;
  check.found = std::string(severity_text(report.severity)) + ", " + age_text(facts.health->age) +
                " old" + active_text(report);
  if (report.severity >= wire::Severity::kMajor) {
    check.verdict = CheckVerdict::kFix;
    check.fix = "stof health " + facts.sensor + " says what each means";
  }
  return check;
}

Check check_key(const CheckFacts& facts) {
  Check check{.name = "key", .found = "the sensor has a key: nobody else changes its settings"};
  if (is_played(facts)) {
    check.verdict = CheckVerdict::kNote;
    check.found = "a recording is played, which takes none";
  } else if (has_condition(facts, wire::Condition::kKeysLost)) {
    check.verdict = CheckVerdict::kFix;
    check.found = "its keys could not be read at its start";
    check.fix = "pair again: stof pair " + facts.sensor;
  } else if (has_condition(facts, wire::Condition::kUnpaired)) {
    check.verdict = CheckVerdict::kNote;
    check.found = "it has none: anybody on the network may change harmless settings";
    check.fix = "stof pair " + facts.sensor;
  }
  return check;
}

Check check_version(const CheckFacts& facts) {
  Check check{.name = "version"};
  if (!facts.identity) {
    check.verdict = CheckVerdict::kNote;
    check.found = "not told: " + facts.no_identity;
  } else if (facts.identity->version != facts.version) {
    check.verdict = CheckVerdict::kNote;
    check.found =
        "the sensor's is " + facts.identity->version + ", this program's " + facts.version;
    check.fix = "update the older one: stof update, or the package stof-tools";
  } else {
    check.found = facts.version + ", as this program's";
  }
  return check;
}

}  // namespace

std::vector<Check> judge_checks(const CheckFacts& facts) {
  if (facts.recorded) {
    return {check_file(facts), check_link(facts), check_clock(facts), check_calibration(facts),
            check_health(facts)};
  }
  std::vector<Check> checks{check_reach(facts), check_firewall(facts), check_mtu(facts),
                            check_buffers(facts)};
  if (facts.stats.figures.frames() != 0) {
    checks.insert(checks.end(), {check_link(facts), check_clock(facts), check_calibration(facts),
                                 check_health(facts), check_key(facts), check_version(facts)});
  } else if (facts.health) {
    checks.insert(checks.end(), {check_health(facts), check_key(facts), check_version(facts)});
  }
  return checks;
}

CheckVerdict worst_of(const std::vector<Check>& checks) {
  CheckVerdict worst = CheckVerdict::kOk;
  for (const Check& check : checks) {
    worst = std::max(worst, check.verdict);
  }
  return worst;
}

std::string checks_text(const std::vector<Check>& checks) {
  std::string text;
  for (const Check& check : checks) {
    text += printed("%-5s %-12s",
                    client::name_in(kVerdictNames, static_cast<std::size_t>(check.verdict)),
                    check.name.c_str()) +
            check.found + (check.fix.empty() ? "" : ": " + check.fix) + "\n";
  }
  return text;
}

nlohmann::ordered_json checks_json(const std::string& source, const std::vector<Check>& checks) {
  using Json = nlohmann::ordered_json;
  const auto name = [](CheckVerdict verdict) {
    return client::name_in(kVerdictNames, static_cast<std::size_t>(verdict));
  };
  Json list = Json::array();
  for (const Check& check : checks) {
    list.push_back({{"name", check.name},
                    {"verdict", name(check.verdict)},
                    {"found", check.found},
                    {"fix", check.fix.empty() ? Json(nullptr) : Json(check.fix)}});
  }
  return {{"source", source}, {"verdict", name(worst_of(checks))}, {"checks", std::move(list)}};
}

}  // namespace stof::host
