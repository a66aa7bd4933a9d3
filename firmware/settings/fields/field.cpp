#include "firmware/settings/fields/field.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "dsp/base/thread_team.h"
#include "dsp/depth/max_range.h"

namespace stof::settings {
namespace {

using Names = std::span<const std::string_view>;

constexpr std::array<std::string_view, 3> kDepthPresets{"fast", "quality", "chapter"};
// wire::Coding in its order: fit is kQuantised.
constexpr std::array<std::string_view, 3> kCodings{"off", "raw", "rvl"};
constexpr std::array<std::string_view, 4> kMapCodings{"off", "raw", "rvl", "fit"};
constexpr std::array<std::string_view, 2> kOffOrOn{"off", "on"};
constexpr std::array<std::string_view, 3> kModes{"off", "stof", "mavlink"};
constexpr std::array<std::string_view, 2> kRequiredSensors{"any", "both"};
constexpr std::array<std::string_view, 3> kStreamLimits{"none", "keep", "fixed"};
constexpr std::array<std::string_view, 3> kProfiles{"sectors", "coarse", "medium"};

// kMember: what a field of the table is in Settings, const or not.
template <auto kMember>
int get_number(const Settings& settings) {
  return static_cast<int>(kMember(settings));
}

template <auto kMember>
void put_number(int value, Settings& settings) {
  auto& to = kMember(settings);
  to = static_cast<std::remove_reference_t<decltype(to)>>(value);
}

template <auto kMember>
constexpr Field whole(std::string_view group, std::string_view name, int low, int high,
                      std::string_view unit, std::string_view meaning,
                      Applies applies = Applies::kNow) {
  return {.group = group,
          .name = name,
          .kind = Kind::kInteger,
          .applies = applies,
          .low = low,
          .high = high,
          .unit = unit,
          .meaning = meaning,
          .number = &get_number<kMember>,
          .set_number = &put_number<kMember>};
}

template <auto kMember>
constexpr Field yes_or_no(std::string_view group, std::string_view name, std::string_view meaning,
                          Applies applies = Applies::kNow) {
  return {.group = group,
          .name = name,
          .kind = Kind::kBoolean,
          .applies = applies,
          .high = 1,
          .meaning = meaning,
          .number = &get_number<kMember>,
          .set_number = &put_number<kMember>};
}

template <auto kMember>
constexpr Field choice(std::string_view group, std::string_view name, Names values,
                       std::string_view meaning) {
  return {.group = group,
          .name = name,
          .kind = Kind::kChoice,
          .high = static_cast<int>(values.size()) - 1,
          .values = values,
          .meaning = meaning,
          .number = &get_number<kMember>,
          .set_number = &put_number<kMember>};
}

template <auto kMember>
constexpr Field text(Kind kind, std::string_view group, std::string_view name, int low,
                     std::size_t high, std::string_view meaning, Applies applies) {
  return {.group = group,
          .name = name,
          .kind = kind,
          .applies = applies,
          .low = low,
          .high = static_cast<int>(high),
          .meaning = meaning,
          .text = [](const Settings& s) { return kMember(s).view(); },
          .set_text =
              [](std::string_view value, Settings& s) {
                auto& to = kMember(s);
                to = std::remove_reference_t<decltype(to)>(value);
              }};
}

// Of a field that others than Access::kTune may change.
constexpr Field by(Access access, Field field) {
  field.access = access;
  return field;
}
constexpr Field by_anybody(const Field& field) { return by(Access::kHarmless, field); }
constexpr Field by_admin(const Field& field) { return by(Access::kAdmin, field); }

template <wire::Stream kStream>
constexpr Field stream(std::string_view name, Names codings, std::string_view meaning) {
  return by_anybody(choice<[](auto& s) -> auto& {
    return s.streams.coding[static_cast<std::size_t>(kStream) - 1];
  }>("streams", name, codings, meaning));
}

constexpr std::array kBefore{
    text<[](auto& s) -> auto& { return s.name; }>(Kind::kText, "", "name", 1, kNameBytes,
                                                  "what discovery calls the sensor", Applies::kNow),
    whole<[](auto& s) -> auto& { return s.period_ms; }>(
        "", "period_ms", 0, kMostPeriodMs, "ms",
        "from one trigger edge to the next; 0: the board's"),
    yes_or_no<[](auto& s) -> auto& { return s.standby; }>(
        "", "standby",
        "no edges and no light while nobody subscribes, from 10 s after the last one on"),
    choice<[](auto& s) -> auto& { return s.depth.preset; }>("depth", "preset", kDepthPresets,
                                                            "how the stereo pair is matched"),
    by_anybody(whole<[](auto& s) -> auto& { return s.depth.max_range_mm; }>(
        "depth", "max_range_mm", dsp::kLeastMaxRangeMm, dsp::kMostMaxRangeMm, "mm",
        "nothing is further away")),
    // What is nearer than the search reaches is seen by nobody.
    by_admin(whole<[](auto& s) -> auto& { return s.depth.disparities; }>(
        "depth", "disparities", 0, dsp::kMaxDisparities, "px",
        "candidates of the search; 0: what the rig asks for")),
    yes_or_no<[](auto& s) -> auto& { return s.depth.guided; }>(
        "depth", "guided", "PMD intervals narrow the search where they can be trusted"),
    yes_or_no<[](auto& s) -> auto& { return s.depth.temporal; }>(
        "depth", "temporal",
        "frames before count where nothing moves: depth is steadier, and averaged"),
    choice<[](auto& s) -> auto& { return s.depth.require; }>(
        "depth", "require", kRequiredSensors,
        "the sensors without which there is no frame: any: where one is missing, the other goes on "
        "alone; both: none without the pair and, where there is one, the PMD camera"),
};

constexpr std::array kAfter{
    stream<wire::Stream::kDepth>("depth", kMapCodings,
                                 "depth; fit: rounded where its interval is wide"),
    stream<wire::Stream::kWidth>("width", kMapCodings, "width of the depth's interval"),
    stream<wire::Stream::kSource>("source", kCodings,
                                  "where each pixel's depth comes from, and why"),
    stream<wire::Stream::kDisparity>("disparity", kCodings, "disparity, stereo alone"),
    stream<wire::Stream::kPmdRaw>("pmd_raw", kCodings, "the PMD camera's four samples"),
    stream<wire::Stream::kGreyLeft>("grey_left", kCodings, "left picture"),
    stream<wire::Stream::kGreyRight>("grey_right", kCodings, "right picture"),
    stream<wire::Stream::kCloud>("cloud", kOffOrOn, "one point for each block of pixels"),
    by_anybody(whole<[](auto& s) -> auto& { return s.streams.cloud_step; }>(
        "streams", "cloud_step", 2, 64, "px", "side of a cloud's block")),
    by_anybody(yes_or_no<[](auto& s) -> auto& { return s.streams.parity; }>(
        "streams", "parity",
        "a packet of parity for each 16, from which one lost packet of them comes back")),
    whole<[](auto& s) -> auto& { return s.pace_percent; }>(
        "streams", "pace_percent", 0, 90, "% of a period",
        "what sending is spread over; 0: at once"),
    by_admin(whole<[](auto& s) -> auto& { return s.udp_port; }>(
        "udp", "port", 1, 65'535, "", "for requests and subscriptions", Applies::kRestart)),
    by_admin(whole<[](auto& s) -> auto& { return s.dscp; }>(
        "udp", "dscp", 0, 63, "", "class of every datagram (RFC 2474), such as 34 for video",
        Applies::kRestart)),
    by_admin(choice<[](auto& s) -> auto& { return s.serial.mode; }>("serial", "mode", kModes,
                                                                    "what the serial line speaks")),
    by_admin(text<[](auto& s) -> auto& { return s.serial.device; }>(
        Kind::kDevice, "serial", "device", 0, kDeviceBytes,
        "the serial line, such as /dev/ttyAMA0; empty: none", Applies::kRestart)),
    by_admin(whole<[](auto& s) -> auto& { return s.serial.baud; }>(
        "serial", "baud", 57'600, 12'000'000, "bit/s", "speed of the serial line")),
    by_admin(yes_or_no<[](auto& s) -> auto& { return s.serial.flow_control; }>(
        "serial", "flow_control", "RTS and CTS hold either side up", Applies::kRestart)),
    by_admin(choice<[](auto& s) -> auto& { return s.serial.profile; }>(
        "serial", "profile", kProfiles,
        "mode stof: nearest obstacle by direction, or depth at about 80x60 or 160x120")),
    by_admin(whole<[](auto& s) -> auto& { return s.serial.rate_hz; }>(
        "serial", "rate_hz", 1, 60, "Hz", "most frames a second on the serial line")),
    by_admin(yes_or_no<[](auto& s) -> auto& { return s.serial.width; }>(
        "serial", "width", "profiles coarse and medium: the interval's width beside depth")),
    by_admin(yes_or_no<[](auto& s) -> auto& { return s.serial.remote; }>(
        "serial", "remote",
        "the line leads to strangers, as a telemetry radio does: they need a key as on the "
        "network")),
    by_admin(whole<[](auto& s) -> auto& { return s.sectors.above_mm; }>(
        "sectors", "above_mm", 0, 10'000, "mm",
        "obstacles count up to this height above the camera")),
    by_admin(whole<[](auto& s) -> auto& { return s.sectors.below_mm; }>(
        "sectors", "below_mm", 0, 10'000, "mm", "and down to this depth below it")),
    by_admin(whole<[](auto& s) -> auto& { return s.sectors.pixels; }>(
        "sectors", "pixels", 1, 1000, "px", "pixels that make an obstacle")),
    by_admin(whole<[](auto& s) -> auto& { return s.sectors.least_mm; }>(
        "sectors", "least_mm", 0, 10'000, "mm", "nearest distance that is told")),
    by_admin(whole<[](auto& s) -> auto& { return s.mavlink.system_id; }>(
        "mavlink", "system_id", 1, 255, "", "MAVLink's number of the vehicle")),
    by_admin(whole<[](auto& s) -> auto& { return s.mavlink.component_id; }>(
        "mavlink", "component_id", 1, 255, "", "and of the sensor in it; 196: obstacle avoidance")),
    by_admin(yes_or_no<[](auto& s) -> auto& { return s.discovery.mdns; }>(
        "discovery", "mdns", "answers to multicast DNS, service _stof._udp")),
    by_admin(yes_or_no<[](auto& s) -> auto& { return s.discovery.beacon; }>(
        "discovery", "beacon", "tells once a second by broadcast where it is")),
    by_admin(yes_or_no<[](auto& s) -> auto& { return s.network.dhcp; }>(
        "network", "dhcp",
        "the sensor asks a DHCP server for an address; this group: image alone")),
    by_admin(yes_or_no<[](auto& s) -> auto& { return s.network.link_local; }>(
        "network", "link_local",
        "where there is no other address, it takes one of 169.254.0.0/16 (RFC 3927)")),
    by_admin(text<[](auto& s) -> auto& { return s.network.address; }>(
        Kind::kInterface, "network", "address", 0, kInterfaceBytes,
        "fixed address with the bits of its network, also beside that of DHCP; empty: none",
        Applies::kNow)),
    by_admin(text<[](auto& s) -> auto& { return s.network.gateway; }>(
        Kind::kIpv4, "network", "gateway", 0, kIpv4Bytes,
        "of that network to all others; empty: none, or that of DHCP", Applies::kNow)),
    by_admin(text<[](auto& s) -> auto& { return s.network.hostname; }>(
        Kind::kHostname, "network", "hostname", 1, kHostnameBytes, "what a DHCP server is told",
        Applies::kNow)),
    by_admin(whole<[](auto& s) -> auto& { return s.compute.threads; }>(
        "compute", "threads", 0, kMostThreads, "",
        "threads that compute depth; 0: one for each processor, at most 4", Applies::kRestart)),
    by_admin(whole<[](auto& s) -> auto& { return s.limits.least_range_mm; }>(
        "limits", "least_range_mm", dsp::kLeastMaxRangeMm, dsp::kMostMaxRangeMm, "mm",
        "only an admin sets depth.max_range_mm below it")),
    by_admin(whole<[](auto& s) -> auto& { return s.limits.least_period_ms; }>(
        "limits", "least_period_ms", 0, 60'000, "ms", "or period_ms below this one")),
    by_admin(whole<[](auto& s) -> auto& { return s.limits.most_period_ms; }>(
        "limits", "most_period_ms", 0, 60'000, "ms", "or above this one")),
    by_admin(choice<[](auto& s) -> auto& { return s.limits.streams; }>(
        "limits", "streams", kStreamLimits,
        "for all but an admin: keep: streams.depth, width, source and cloud are not switched off; "
        "fixed: no stream is changed")),
};
static_assert(kMostThreads == dsp::ThreadTeam::kMost);
static_assert(kUsualThreads == 4, "said in the table");

constexpr std::string_view kMatchGroup = "depth.match";

// The matcher's own options.
std::size_t match_count() noexcept { return dsp::match_options().size(); }

Field match_field(std::size_t slot) noexcept {
  const dsp::MatchOption& option = dsp::match_options()[slot];
  return {.group = kMatchGroup,
          .name = option.name,
          .kind = Kind::kMatch,
          .access = option.name == "min-disparity" ? Access::kAdmin : Access::kTune,
          .meaning = option.meaning,
          .option = &option,
          .slot = slot};
}

}  // namespace

std::size_t field_count() noexcept { return kBefore.size() + match_count() + kAfter.size(); }

Field field(std::size_t place) noexcept {
  if (place < kBefore.size()) {
    return kBefore[place];
  }
  place -= kBefore.size();
  const std::size_t matches = match_count();
  return place < matches ? match_field(place) : kAfter[place - matches];
}

std::size_t find_field(std::string_view path) noexcept {
  const std::size_t dot = path.rfind('.');
  const bool top = dot == std::string_view::npos;
  const std::string_view group = top ? std::string_view() : path.substr(0, dot);
  const std::string_view name = top ? path : path.substr(dot + 1);
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    const Field candidate = field(place);
    if (candidate.group == group && candidate.name == name && (top || dot > 0)) {
      return place;
    }
  }
  return count;
}

bool is_group(std::string_view path) noexcept {
  const auto of_group = [path](const Field& field) { return field.group == path; };
  return !path.empty() && (path == kMatchGroup || std::ranges::any_of(kBefore, of_group) ||
                           std::ranges::any_of(kAfter, of_group));
}

}  // namespace stof::settings
