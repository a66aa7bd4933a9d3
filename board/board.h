#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "board/replay.h"
#include "dsp/base/status.h"
#include "dsp/calib/calibration.h"
#include "hal/button.h"
#include "hal/clock.h"
#include "hal/datagram_port.h"
#include "hal/disk.h"
#include "hal/network_interfaces.h"
#include "hal/pmd_camera.h"
#include "hal/serial_port.h"
#include "hal/slots.h"
#include "hal/stereo_camera.h"
#include "hal/store.h"
#include "hal/time.h"
#include "hal/trigger.h"
#include "hal/watchdog.h"

// Which board this is was chosen at link time; its table kConfig by the build.
#include STOF_BOARD_CONFIG

namespace stof::board {

// The devices of a board that is open, and what is known about the rig in front of it. A list, as
// long as there are kinds of devices.
struct Board {
  hal::Clock& clock;
  hal::Trigger& trigger;
  hal::StereoCamera& stereo;
  hal::PmdCamera* pmd;  // nullptr: this rig has none, depth comes from stereo alone
  hal::DatagramPort& port;
  hal::SerialPort* serial;      // nullptr: none was asked for
  std::optional<hal::Peer> to;  // gets every packet without having asked for it
  hal::NetworkInterfaces& network;
  hal::DatagramPort* beacon = nullptr;  // takes broadcasts, alone; nullptr: none can be had
  hal::MulticastPort* mdns;             // nullptr: none was asked for, or it cannot be had
  hal::Watchdog* watchdog = nullptr;    // nullptr: nobody restarts a board that stands still
  hal::Button* button = nullptr;        // that opens pairing and accepts its digits; nullptr: none
  dsp::Calibration calibration;
  bool nominal_calibration = false;        // of the drawing: nothing was measured
  bool allow_nominal_calibration = false;  // and whoever started it knows
  int disparities;                         // search range that the rig asks for
  hal::Duration least_period{};            // with a shorter one frames cannot be told apart
  bool emulated_time;                      // the clock is not this machine's
  bool other_port = false;                 // than the one that was asked for
  Replay* replay = nullptr;                // edges and frames are those of a recording
  bool recorded = false;                   // what cameras see comes of files, and again and again
  std::vector<std::string>
      notes;  // lines that whoever started it should read, such as what is missing
};

// How a board talks; decided by settings and command line.
struct Connections {
  std::uint16_t udp_port = 7560;  // 0: any free one
  std::string to;                 // HOST:PORT; empty: nobody gets packets who has not subscribed
  std::string serial;             // device file of the serial line; empty: none
  std::uint32_t baud = 921'600;
  bool flow_control = false;  // of the serial line, RTS and CTS
  int dscp = 0;               // of every datagram, 0..63
  bool mdns = false;
  // Who named it stands before it, and is told where it cannot be had. Else another port is taken,
  // and the serial line is opened as soon as it can be.
  bool port_required = true;
  bool serial_required = true;
};

// Options that a board could not fulfil: one line, what, where and what to do.
struct Refusal {
  std::string message;
  bool device = false;  // the options were fine, a device failed
};

// Opens the devices; may allocate and take a second or two. `arguments` are the board's own command
// line flags (after the common ones were taken out); unknown ones are refused. The board lives
// until the program ends; call once.
std::expected<Board*, Refusal> open(const Connections& connections,
                                    std::span<const std::string_view> arguments);

// Devices that can be lost or hang, and opened again by reopen().
enum class Device : std::uint8_t { kTrigger, kStereo, kPmd };
inline constexpr std::size_t kDeviceCount = 3;

// Opens a device again, in place, that has returned kDeviceLost, or a camera that repeats itself,
// which is shut before. For any thread, one at a time:
// nobody else uses the device meanwhile or holds a frame of it, while the others may be in use (but
// the cameras not while the trigger is opened, whose strobe lines they read). May allocate, and
// block for seconds where a driver hangs. kOk: go on. kDeviceLost: not back yet, try again later.
Status reopen(Board& board, Device device) noexcept;

// Keeps the program's memory in RAM from now on, and readies the stack of the calling thread, where
// the board's table asks for priority. A line: what the system refuses and what to do; it goes on.
std::optional<std::string> lock_memory();
// No core file of this program, and nobody but an administrator looks into it: it holds secrets.
void keep_memory_private() noexcept;
// The calling thread, and those that it starts meanwhile, run before everything else on the board
// (true, with the priority that it was opened with), or as everything does. A line: as above.
std::optional<std::string> set_realtime_priority(bool realtime);

// Heap calls of a thread since count_heap_calls().
struct HeapCalls {
  bool counted = false;         // this build counts them
  std::uint64_t own = 0;        // ours: none is allowed in the loop
  std::uint64_t libraries = 0;  // inside of device libraries that cannot do without
};
// From now on those of the calling thread are counted.
void count_heap_calls() noexcept;
HeapCalls heap_calls() noexcept;

// Where settings are kept under that name, or what its owner alone may read; nothing is opened yet.
std::unique_ptr<hal::Store> make_store(std::string_view name);
std::unique_ptr<hal::Store> make_secret_store(std::string_view name);

// This program alone from now on, until it ends, keeps something in that file or partition; make:
// makes the file. Waits a moment for one that is just ending. kWouldBlock: another one does. Other
// errors: there is no lock to be had, nobody is kept out.
Status hold_alone(std::string_view name, bool make);

// A partition, or a file in its place. May allocate. Errors as hal::linux::FileDisk.
Result<std::unique_ptr<hal::Disk>> make_disk(std::string_view name);

// The disk that this start came from, by the common name of its partitions, or files in their
// place: 1, 2 and 3 are put behind it. May allocate. kDeviceError, kUnsupported: as
// hal::linux::FileSlots.
Result<std::unique_ptr<hal::Slots>> make_slots(std::string_view prefix);

// Restarts the machine; trial: once with the other slot. Returns where it is refused: kDeviceError;
// kUnsupported: this board is no machine of its own.
Status restart_machine(bool trial) noexcept;

// The board's own flags, one per line, for --help.
std::string_view usage() noexcept;

}  // namespace stof::board
