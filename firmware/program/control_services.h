#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "board/board.h"
#include "firmware/control/control_thread.h"
#include "firmware/control/lease_table.h"
#include "firmware/control/periodic_task.h"
#include "firmware/control/receiver_list.h"
#include "firmware/control/request_handler.h"
#include "firmware/discovery/beacon.h"
#include "firmware/discovery/mdns_agent.h"
#include "firmware/keys/authenticator.h"
#include "firmware/keys/button_watcher.h"
#include "firmware/keys/key_service.h"
#include "firmware/keys/keyring.h"
#include "firmware/keys/pairing_server.h"
#include "firmware/program/appliance.h"
#include "firmware/program/calibration_installer.h"
#include "firmware/program/run_config.h"
#include "firmware/serial/line/byte_ring.h"
#include "firmware/serial/line/serial_link.h"
#include "firmware/serial/line/serial_request_handler.h"
#include "firmware/settings/saved_settings.h"
#include "firmware/settings/settings_server.h"
#include "firmware/settings/settings_trial.h"
#include "firmware/update/updater.h"
#include "firmware/upload/upload_server.h"

namespace stof::firmware {

// The loop's state, for the control thread.
struct LoopStatus {
  std::atomic<std::uint32_t> rate_millihertz = 0;
  std::atomic<wire::Health> health = wire::Health::kOk;
  std::atomic<std::uint64_t> published = 0;  // frames
  std::atomic<std::uint64_t> with_pair = 0;  // of these, as Counters
  std::atomic<std::uint64_t> with_pmd = 0;
  std::atomic<std::uint64_t> rounds = 0;
  std::atomic<bool> standby = false;
  std::atomic<std::uint32_t> installs = 0;  // RunConfig::installs that they are made with
  static_assert(std::atomic<wire::Health>::is_always_lock_free);
};

// Everything that the control thread does, put together: requests, subscriptions, settings,
// discovery, the serial line. Rings and atomics carry what the loop needs.
class ControlServices final : public settings::Limits,
                              public settings::SettingsSink,
                              public CalibrationInstaller::Sink,
                              public PeriodicTask {
 public:
  struct Parts {
    board::Board& board;
    RigInfo& rig;                          // the control thread's own from now on
    hal::Store* store;                     // of settings; nullptr: nothing is kept
    hal::Store* fixed;                     // SettingsStores::fixed
    hal::Store* installed;                 // calibration; nullptr: none can be
    settings::NetworkTrial* network;       // begun; nullptr: the system's network is not ours
    update::Updater& updater;              // the control thread's own from now on
    const settings::StartSettings& saved;  // that the start found there
    settings::SettingsTrial* trial;        // of these and later ones; nullptr: nothing is kept
    keys::Keyring& keys;                   // the control thread's own from now on
    keys::PairingServer& pairing;          // likewise
    std::uint32_t connection_replaced;     // the value of the condition; 0: none was
    wire::Origin origin;
    wire::Announce announce;  // what does not change: serial, version, board, port, picture's size
    RunConfigRing& run_configs;
    ChangeRing& changes;
    ReceiverRing& receivers;
    ByteRing* serial;  // nullptr: there is no line
    const LoopStatus& loop_status;
    std::atomic<update::Restart>& restart;  // that the board shall make
  };

  // active: what the loop begins with, as revision 1. The thread starts at once.
  ControlServices(const Parts& parts, const settings::Settings& active);
  // Ends the thread; says goodbye where it was announced.
  ~ControlServices() override;
  ControlServices(const ControlServices&) = delete;
  ControlServices& operator=(const ControlServices&) = delete;

  // For the loop's thread. `made`: the counters of its end of the serial line.
  ControlStatus status(const SerialSender::Counters& made) const noexcept;

  bool accepts(const settings::Settings& settings, settings::PagedWriter& why) noexcept override;
  bool apply(const settings::Settings& settings, std::uint32_t revision) noexcept override;
  bool rig_in_force() noexcept override;
  wire::SettingsResult takes_rig(settings::PagedWriter& why) noexcept override;
  void use_rig() noexcept override;
  void tick(hal::Time now) noexcept override;

 private:
  wire::Announce make_announce() const noexcept;
  // Renews what requests and discovery are answered with.
  wire::Announce update_announce(hal::Time now) noexcept;
  void publish_status() noexcept;
  void watch_pairing(hal::Time now) noexcept;
  void watch_update(hal::Time now) noexcept;

  Parts parts_;
  settings::SettingsServer settings_server_;
  LeaseTable subscribers_;
  keys::Authenticator authenticator_;
  keys::KeyService key_service_;
  CalibrationInstaller installer_;
  upload::UploadServer uploads_;
  std::optional<keys::ButtonWatcher> button_;
  RequestHandler handler_;
  Beacon beacon_;
  std::optional<MdnsAgent> mdns_;
  std::optional<SerialRequestHandler> line_requests_;
  std::optional<SerialLink> serial_;
  settings::Text<settings::kNameBytes + 1> mdns_name_;
  bool mdns_on_ = true;
  hal::Time started_ = control_now();
  std::array<PeriodicTask*, 1> tasks_{this};

  // The state that status() reads on the loop's thread.
  struct {
    std::atomic<std::uint32_t> revision = 1;
    std::atomic<std::uint8_t> subscribers = 0;
    std::atomic<bool> unsaved = false;
    std::atomic<bool> fell_back = false;
    std::atomic<bool> restart_needed = false;
    std::atomic<std::uint32_t> dropped = 0;
    std::atomic<std::uint32_t> calibration_dropped = 0;
    std::atomic<keys::Pairing> paired = keys::Pairing::kUnpaired;
    std::atomic<std::uint32_t> release = kNoRelease;
    std::atomic<std::uint32_t> release_fingerprint = 0;
    std::atomic<bool> keep_awake = false;
  } published_;

  std::optional<ControlThread> thread_;
};

// Fills `to` up with 0; cuts off what does not fit.
void put_text(std::string_view text, std::span<char> to) noexcept;

}  // namespace stof::firmware
