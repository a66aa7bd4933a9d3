#include "host/cli/evaluate.h"

#include <array>
#include <cstdio>

#include "host/cli/exit.h"

namespace stof::host {

void add_evaluate_flags(CLI::App& command, EvaluateOptions& options) {
  MatchOptions& match = options.match;
  command.add_option("--method", match.method, "wta (dp, so, sgm, sa: not in this version)")
      ->capture_default_str();
  command.add_option("--cost", match.cost, "sad (ssd, census5, census9x7: not in this version)")
      ->capture_default_str();
  command.add_option("--block", match.block, "Block, WxH px, 1x1 to 64x64")->capture_default_str();
  command.add_flag("--lr", match.left_right, "Drop what the left-right check rejects");
  command.add_flag("--subpixel", match.subpixel, "Fit the cost to 1/16 px");
  command.add_option("--preset", match.preset, "Not in this version");
  command.add_flag("--fill", match.fill, "Not in this version");
  command.add_option("--runs", match.runs, "Runs of which the median time is printed")
      ->capture_default_str();
  command.add_flag("--json", options.json, "Machine-readable result on stdout");
  command.add_option("--out", options.out, "Folder for the maps, made where missing");
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, error)) {
    throw Failure(
        Exit::kBadInput,
        folder.string() + ": cannot be made a folder: check the path and its permissions");
  }
}

std::string percent_text(std::optional<double> share, int columns) {
  std::array<char, 64> text{};
  if (share) {
    std::snprintf(text.data(), text.size(), "%*.2f", columns, 100 * *share);
  } else {
    std::snprintf(text.data(), text.size(), "%*s", columns, "-");
  }
  return text.data();
}

}  // namespace stof::host
