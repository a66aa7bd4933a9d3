#include "host/cli/sensor_text.h"

#include "firmware/wire/messages/conditions.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

std::string name_of(std::uint8_t condition) {
  const wire::ConditionInfo* const info = wire::info_of(static_cast<wire::Condition>(condition));
  return info != nullptr ? info->name : "condition " + std::to_string(condition);
}

// Who changed the settings, of the condition's value: the last four bytes of an address, which are
// all of an IPv4 address.
std::string changer(std::uint32_t value) {
  if (value == 0) {
    return "the serial line";
  }
  return printed("the address that ends in %u.%u.%u.%u", value >> 24, value >> 16 & 0xFF,
                 value >> 8 & 0xFF, value & 0xFF);
}

// Of the sensor's last second: nothing before its first one has passed, no latency without a frame.
std::string last_second(const wire::HealthReport& health) {
  constexpr std::uint32_t kFirstMs = 2000;
  std::string text;
  if (health.rate_millihertz != 0 || health.uptime_ms >= kFirstMs) {
    text += printed("%.1f frames/s, ", health.rate_millihertz / 1e3);
  }
  if (health.latency_us != 0) {
    text += printed("latency %.1f ms mean %.1f ms longest, ", health.latency_us / 1e3,
                    health.longest_latency_us / 1e3);
  }
  return text;
}

template <typename T>
void add_stream(std::string& line, const char* name, dsp::ImageView<const T> image,
                const char* more = "") {
  if (!image.empty()) {
    line += std::string(line.empty() ? "streams: " : ", ") + name + " " +
            std::to_string(image.width()) + "x" + std::to_string(image.height()) + more;
  }
}

}  // namespace

const char* severity_text(wire::Severity severity) {
  switch (severity) {
    case wire::Severity::kInfo:
      return "good";
    case wire::Severity::kMinor:
      return "minor trouble";
    case wire::Severity::kMajor:
      return "major trouble";
    case wire::Severity::kCritical:
      return "no data";
  }
  return "trouble of an unknown kind";
}

const char* reaction_text(wire::Reaction reaction) {
  switch (reaction) {
    case wire::Reaction::kNone:
      return "go on";
    case wire::Reaction::kWatch:
      return "go on, and tell whoever maintains the robot";
    case wire::Reaction::kSlow:
      return "slow down: expect gaps";
    case wire::Reaction::kStop:
      return "bring the robot to a safe stop";
  }
  return "bring the robot to a safe stop: the reaction is of a newer sensor";
}

namespace {

std::string release_line(const wire::EventReport& event) {
  constexpr std::uint32_t kConfirmed = 2;
  constexpr std::uint32_t kLeft = 3;
  std::string line = printed("event: release %08x ", event.former);
  if (event.active != 0) {
    line +=
        "runs on trial: it is confirmed within two minutes, or the sensor restarts with the "
        "former one";
  } else if (event.value == kConfirmed) {
    line += "is confirmed";
  } else if (event.value == kLeft) {
    line += "was not confirmed: the former one runs again";
  } else {
    line += "is no longer on trial";
  }
  return line + "; " +
         reaction_text(event.active != 0 || event.value == kLeft ? event.reaction
                                                                 : wire::Reaction::kNone);
}

}  // namespace

std::string event_line(const wire::EventReport& event) {
  const wire::ConditionInfo* const info =
      wire::info_of(static_cast<wire::Condition>(event.condition));
  std::string line = "event: " + name_of(event.condition);
  if (static_cast<wire::Condition>(event.condition) == wire::Condition::kReleaseOnTrial) {
    return release_line(event);
  }
  if (event.active == 0) {
    return line + " ended";
  }
  line += " began";
  if (info != nullptr) {
    line += std::string(": ") + info->text;
  }
  if (static_cast<wire::Condition>(event.condition) == wire::Condition::kSettingsChanged) {
    constexpr std::uint32_t kNetworkOnTrial = 1;
    constexpr std::uint32_t kNetworkTakenBack = 2;
    line += event.former == kNetworkTakenBack
                ? " (the network is as before: nobody saved its change in time)"
                : " (by " + changer(event.value) +
                      (event.former == kNetworkOnTrial ? "; the network is on trial)" : ")");
  }
  if (static_cast<wire::Condition>(event.condition) == wire::Condition::kCalibrationChanged) {
    line += printed(" (%08x in place of %08x)", event.value, event.former);
  }
  return line + "; " + reaction_text(event.reaction);
}

std::string active_text(const wire::HealthReport& health) {
  std::string names;
  for (std::uint8_t k = 0; k < 32; ++k) {
    if (((health.active >> k) & 1) != 0) {
      names += " " + name_of(k);
    }
  }
  return names.empty() ? names : ", active:" + names;
}

std::string lenses_contradict_text() {
  return "two lenses under one fingerprint: somebody else spoke in the sensor's name, and which "
         "one "
         "is true is not known";
}

std::string link_text(const client::LinkState& link) {
  const std::string text = std::string(link.silent ? " silent" : "") +
                           (link.restarted ? " restarted" : "") +
                           (link.forged_traffic ? " forged traffic" : "") +
                           (link.delayed ? " delayed" : "") + (link.no_key ? " no key" : "");
  return text.empty() ? text : ", link:" + text;
}

std::string health_line(const wire::HealthReport& health) {
  std::string line = std::string("health: ") + severity_text(health.severity) + ", up " +
                     std::to_string(health.uptime_ms / 1000) + " s, " + last_second(health) +
                     std::to_string(health.subscribers) +
                     (health.subscribers == 1 ? " subscriber" : " subscribers") +
                     active_text(health);
  if (health.active != 0) {
    line += std::string("; ") + reaction_text(health.reaction);
  }
  return line;
}

const char* alone_text(wire::Sensors sensors) {
  switch (sensors) {
    case wire::kStereoSensor:
      return "the stereo pair alone";
    case wire::kPmdSensor:
      return "the PMD camera alone";
    default:
      return "";
  }
}

std::string streams_line(const client::Frame& frame) {
  std::string line;
  add_stream(line, "depth", frame.depth);
  add_stream(line, "width", frame.interval_width);
  add_stream(line, "source", frame.source);
  add_stream(line, "disparity", frame.disparity);
  add_stream(line, "pmd", frame.pmd.front(), " x 4");
  add_stream(line, "left", frame.left);
  add_stream(line, "right", frame.right);
  add_stream(line, "cloud", frame.cloud);
  return line.empty() ? "streams: none" : line;
}

}  // namespace stof::host
