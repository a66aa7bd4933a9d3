#include "host/cli/recording/recover.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/recording/damage_text.h"
#include "host/cli/recording/reading_progress.h"
#include "host/client/printable.h"
#include "host/recording/mcap/recover.h"
#include "host/text/printed.h"

namespace stof::host {

void recover(const RecoverOptions& options) {
  const bool in_place = options.out.empty();
  if (in_place && options.force) {
    throw Failure(Exit::kBadInput, "--force: replaces OUT: name it");
  }
  using Existing = mcap::FileSink::Existing;
  const Existing existing = options.force ? Existing::kReplace : Existing::kRefuse;
  const mcap::Recovered result = [&] {
    ReadingProgress progress(options.file.string(), options.json);
    return value_or_fail(
        in_place ? mcap::recover(options.file, progress.callback())
                 : mcap::recover(options.file, options.out, existing, progress.callback()));
  }();
  const std::string name = (in_place ? options.file : options.out).string();
  const std::string file = client::printable(name);
  if (options.json) {
    const nlohmann::ordered_json json{{"file", name},
                                      {"was_whole", result.was_whole},
                                      {"messages", result.messages},
                                      {"cut_bytes", result.cut_bytes},
                                      {"damaged", result.damaged},
                                      {"damaged_bytes", result.damaged_bytes},
                                      {"files", result.files}};
    say_json(json);
  } else if (result.was_whole) {
    std::printf("%s: is whole, nothing was changed\n", file.c_str());
  } else {
    std::printf(
        "%s: whole, %llu messages; given up: %llu bytes at the end, %llu damaged records (%llu "
        "bytes)\n",
        file.c_str(), static_cast<unsigned long long>(result.messages),
        static_cast<unsigned long long>(result.cut_bytes),
        static_cast<unsigned long long>(result.damaged),
        static_cast<unsigned long long>(result.damaged_bytes));
    if (result.files > 1) {
      std::printf(
          "%u recordings lay in it, one behind the other: what is between them counts as lost in "
          "OUT\n",
          result.files);
    }
  }
  if (!in_place && result.damaged != 0) {
    throw Failure(Exit::kFailure, options.file.string() + ": " +
                                      damage_text(result.damaged, result.damaged_bytes) +
                                      ", and are not in " + file);
  }
}

void add_recover(CLI::App& app, RecoverOptions& options) {
  CLI::App& command =
      *app.add_subcommand("recover", "Give a recording that was cut its index again");
  command.footer(
      "Example: stof recover hall.mcap\n"
      "In place the file is cut behind its last whole record, and the index is added: no other "
      "byte "
      "changes. Where anything sound follows damage, or another program writes FILE, it is refused "
      "and stays as it is: OUT gets all that is sound.\n"
      "Ends with 0 (FILE or OUT is whole now), 1 (OUT is whole, without records that are damaged) "
      "or 2 (it cannot be read or written).");
  command.add_option("FILE", options.file, "The recording")->required();
  command.add_option("OUT", options.out,
                     "Leave FILE as it is, and write all that is sound in it here");
  command.add_flag("--force", options.force, "Replace OUT where it is there");
  add_json_flag(command, options.json);
  command.callback([&options] { recover(options); });
}

}  // namespace stof::host
