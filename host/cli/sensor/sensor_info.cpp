#include "host/cli/sensor/sensor_info.h"

#include <chrono>

#include "host/cli/config/settings_text.h"
#include "host/cli/live/reception.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/sensor_text.h"
#include "host/client/printable.h"
#include "host/client/value_names.h"
#include "host/discovery/discover.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kFixedPixel = 65536;

Json parsed_or_null(const std::string& document) {
  const Json json = Json::parse(document, nullptr, false);
  return json.is_discarded() ? Json(nullptr) : json;
}

std::string identity_text(const SensorInfo& info) {
  if (!info.identity) {
    return "  it does not say who it is: " +
           (info.no_identity.empty() ? "a replay" : info.no_identity) + "\n";
  }
  const client::FoundSensor& one = *info.identity;
  return "  serial " + one.serial +
         (one.name.empty() ? ", name not told" : ", name '" + one.name + "'") +
         (info.is_signed ? "; without a signature: board " : ", board ") + one.board +
         ", version " + one.version +
         printed(", %u of %u subscribers\n", one.subscribers, one.most_subscribers);
}

// What a signature proves of it takes the place of what anybody may announce.
void prove(client::FoundSensor& identity, const SensorInfo& info) {
  identity.serial = printed("%08x", info.device_id);
  identity.name =
      client::printable(name_in_settings(read_json(info.documents.settings).value_or(Json())));
}

}  // namespace

std::expected<client::FoundSensor, std::string> ask_identity(const ReceiveOptions& options,
                                                             bool sends,
                                                             std::optional<std::uint32_t> device) {
  const std::chrono::duration<double> patience(sends ? options.timeout_s : 1);
  auto identity =
      client::ask_sensor(sensor_address(options.sensor),
                         std::chrono::duration_cast<std::chrono::milliseconds>(patience), device);
  if (!identity) {
    return std::unexpected(identity.error().message);
  }
  return std::move(*identity);
}

SensorInfo read_sensor_info(const ReceiveOptions& options) {
  constexpr int kTries = 3;
  const std::chrono::duration<double> patience(options.timeout_s);
  SensorInfo info;
  bool replay = false;
  Reception reception(options, {.frame = [&](const client::Frame& frame) {
                        info.device_id = frame.origin.device_id;
                        info.streams = streams_line(frame);
                        info.clock = client::clock_text(frame.stamp.clock);
                        replay = frame.stamp.clock == wire::ClockState::kRecorded;
                        if (frame.info) {
                          info.settings_revision = frame.info->settings_revision;
                          info.settings_fingerprint = frame.info->settings_fingerprint;
                        }
                      }});
  // Health and calibration come once a second.
  std::optional<client::Time> began;
  reception.run([&] {
    const client::Time now = client::Time::clock::now();
    const client::Receiver& receiver = reception.receiver();
    if (!began && reception.frames() != 0) {
      began = now;
    }
    return began && ((receiver.calibration() && receiver.health()) || now - *began > patience);
  });
  if (reception.frames() == 0) {
    reception.fail();
  }
  const client::Receiver& receiver = reception.receiver();
  info.place = reception.place();
  info.calibration = receiver.calibration();
  if (receiver.health()) {
    info.health = HealthState{
        .source = info.place, .report = *receiver.health(), .age = receiver.link().health_age};
  }
  if (replay) {  // it answers subscriptions alone
    return info;
  }
  for (int i = 0; i < kTries && info.documents.settings.empty(); ++i) {
    info.documents = read_documents(options, false);
  }
  if (auto identity = ask_identity(options, true, info.device_id)) {
    info.identity = std::move(*identity);
  } else {
    info.no_identity = std::move(identity.error());
  }
  info.is_signed = options.signed_streams;
  if (info.identity && info.is_signed) {
    prove(*info.identity, info);
  }
  return info;
}

std::string calibration_line(const wire::CalibrationPacket& one) {
  return printed(
      "calibration: %ux%u px, fx %.2f fy %.2f cx %.2f cy %.2f px, baseline %.1f mm, PMD %ux%u px",
      one.image_width, one.image_height, one.fx / kFixedPixel, one.fy / kFixedPixel,
      one.cx / kFixedPixel, one.cy / kFixedPixel, static_cast<double>(one.baseline_nm) / 1e6,
      one.pmd_width, one.pmd_height);
}

Json calibration_json(const wire::CalibrationPacket& one) {
  return {{"width", one.image_width},
          {"height", one.image_height},
          {"fx", one.fx / kFixedPixel},
          {"fy", one.fy / kFixedPixel},
          {"cx", one.cx / kFixedPixel},
          {"cy", one.cy / kFixedPixel},
          {"baseline_m", static_cast<double>(one.baseline_nm) / 1e9},
          {"depth_unit_um", one.depth_unit_um},
          {"pmd_width", one.pmd_width},
          {"pmd_height", one.pmd_height}};
}

std::string sensor_info_text(const SensorInfo& info) {
  std::string text = info.place + ", sensor " + std::to_string(info.device_id) + "\n";
  text += identity_text(info);
  text += "  " + info.streams + "\n  clock: " + info.clock + "\n";
  text += printed("  settings: revision %u, fingerprint %08x%s\n", info.settings_revision,
                  info.settings_fingerprint,
                  info.documents.settings.empty() ? ", not given" : "; --json has them");
  text += info.calibration ? "  " + calibration_line(*info.calibration) +
                                 printed(", fingerprint %08x\n", info.calibration->fingerprint)
                           : "  calibration: none came\n";
  text += info.health ? "  " + health_line(info.health->report) + "\n" : "  health: none came\n";
  return text;
}

Json sensor_info_json(const SensorInfo& info) {
  Json identity = nullptr;
  if (info.identity) {
    identity = {{"serial", info.identity->serial},
                {"name", info.identity->name},
                {"board", info.identity->board},
                {"version", info.identity->version},
                {"address", info.identity->address},
                {"port", info.identity->port},
                {"most_subscribers", info.identity->most_subscribers}};
    if (info.is_signed) {
      identity["unsigned"] = {"board", "version", "address", "port", "most_subscribers"};
    }
  }
  Json calibration = nullptr;
  if (info.calibration) {
    calibration = calibration_json(*info.calibration);
    calibration["fingerprint"] = printed("%08x", info.calibration->fingerprint);
    calibration["period_ms"] = static_cast<double>(info.calibration->period_ns) / 1e6;
  }
  return {{"place", info.place},
          {"device_id", info.device_id},
          {"identity", std::move(identity)},
          {"streams", info.streams},
          {"clock", info.clock},
          {"settings_revision", info.settings_revision},
          {"settings_fingerprint", printed("%08x", info.settings_fingerprint)},
          {"settings", parsed_or_null(info.documents.settings)},
          {"calibration", std::move(calibration)},
          {"health", info.health ? health_json(*info.health) : Json(nullptr)}};
}

}  // namespace stof::host
