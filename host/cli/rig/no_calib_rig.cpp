#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/rig/calib_rig.h"

namespace stof::host {

bool has_calib_rig() noexcept { return false; }

void add_calib_rig(CLI::App& calib, CalibRigOptions& /*options*/) {
  for (const char* const name : {"stereo", "extrinsics", "check", "import", "export", "target"}) {
    CLI::App& command = *calib.add_subcommand(name, "Not in this build (scripts/setup calib)");
    show_example(command, calib_rig_example(name));
    command.allow_extras();
    command.callback([name] {
      throw Failure(Exit::kBadInput, std::string("calib ") + name + ": " + kRigAbsence);
    });
  }
}

}  // namespace stof::host
