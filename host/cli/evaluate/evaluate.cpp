#include "host/cli/evaluate/evaluate.h"

#include <nlohmann/json.hpp>

#include "host/cli/failure.h"
#include "host/text/printed.h"
#include "lab/match_options.h"

namespace stof::host {

void add_runs_flag(CLI::App& command, EvaluateOptions& options) {
  command.add_option("--runs", options.match.runs, "Runs of which the median time is printed")
      ->capture_default_str();
}

void add_evaluate_flags(CLI::App& command, EvaluateOptions& options, Judged judged) {
  MatchRequest& match = options.match;
  const bool disparity = judged == Judged::kDisparity;
  command.add_option("--preset", match.preset,
                     "Matching preset: fast, quality or chapter; what follows changes it (default: "
                     "a method alone, dense and integer). --NAME{VALUE}: the name alone is that "
                     "value, another one follows \"=\", such as --lr=2");
  for (const lab::MatchOption& option : lab::match_options()) {
    const std::string name(option.name);
    if (name == "fill" && !disparity) {
      continue;
    }
    const std::string help =
        std::string(option.meaning) + ": " + std::string(option.values) +
        (name == "method" && disparity ? ", or sa (simulated annealing, offline)" : "");
    // Where the name alone has a meaning a value follows "=": what comes next is a scene.
    CLI::Option* const added =
        option.alone.empty()
            ? command.add_option("--" + name, help)->expected(1)
            : command.add_flag("--" + name + "{" + std::string(option.alone) + "}", help);
    added->each(
        [&match, name](const std::string& value) { match.settings.emplace_back(name, value); });
  }
  if (disparity) {
    command.add_flag("--hill-climbing", match.hill_climbing, "sa: no rise of energy is accepted");
    command.add_option("--seed", match.seed, "sa: of its random numbers, 1 without");
    command.add_flag("--energy", match.energy,
                     "Print the map's energy: costs and changes of disparity; slow");
  }
  command
      .add_option("--threads", match.threads,
                  std::string("Threads that compute, 1 to 8; times depend on it, results do not") +
                      (disparity ? " (sa has one)" : ""))
      ->capture_default_str();
  command.add_flag("--json", options.json, "Machine-readable result on stdout");
}

void add_out_flag(CLI::App& command, EvaluateOptions& options) {
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
  return share ? printed("%*.2f", columns, 100 * *share) : printed("%*s", columns, "-");
}

nlohmann::ordered_json json_number(std::optional<double> value, double unit) {
  return value ? nlohmann::ordered_json(*value * unit) : nlohmann::ordered_json(nullptr);
}

}  // namespace stof::host
