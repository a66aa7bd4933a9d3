#include "host/cli/words.h"

#include <algorithm>
#include <vector>

#include "host/cli/failure.h"

namespace stof::host {
namespace {

// Damerau-Levenshtein distance, of neighbours that are exchanged once (optimal string alignment).
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> rows(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        rows[i][j] = i + j;
        continue;
      }
      rows[i][j] = std::min({rows[i - 1][j] + 1, rows[i][j - 1] + 1,
                             rows[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        rows[i][j] = std::min(rows[i][j], rows[i - 2][j - 2] + 1);
      }
    }
  }
  return rows[a.size()][b.size()];
}

std::string meant_text(std::string_view word, std::span<const std::string> known) {
  const std::string near = nearest_word(word, known);
  return near.empty() ? "" : ", did you mean " + near;
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* const below : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(below->get_name());
  }
  return names;
}

const CLI::App* find_command(const CLI::App& app, std::string_view name) {
  const auto all = app.get_subcommands([](const CLI::App*) { return true; });
  const auto found =
      std::ranges::find(all, name, [](const CLI::App* one) { return one->get_name(); });
  return found == all.end() ? nullptr : *found;
}

// With two dashes each.
std::vector<std::string> flags_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      names.push_back("--" + name);
    }
  }
  return names;
}

void judge_flag(const CLI::App& command, const std::string& path, std::string_view word) {
  const std::string_view name = word.substr(0, word.find('='));
  const std::vector<std::string> known = flags_of(command);
  if (std::ranges::find(known, name) == known.end()) {
    throw Failure(Exit::kBadInput, std::string(name) + ": " + path + " has no such flag" +
                                       meant_text(name, known) + ": try " + path + " --help");
  }
}

}  // namespace

std::string nearest_word(std::string_view word, std::span<const std::string> known) {
  constexpr std::size_t kMostLetters = 64;  // what is longer is no mistyped word
  if (word.size() > kMostLetters) {
    return {};
  }
  const auto best = std::ranges::min_element(
      known, {}, [&](const std::string& one) { return distance(word, one); });
  const std::size_t most = std::max<std::size_t>(1, word.size() / 3);
  return best != known.end() && distance(word, *best) <= most ? *best : std::string();
}

void judge_words(const CLI::App& app, std::span<char* const> words) {
  const CLI::App* command = &app;
  std::string path = app.get_name();
  for (const std::string_view word : words) {
    if (word == "--") {
      return;
    }
    if (command->get_allow_extras()) {
      return;  // it takes anything, to refuse it in its own words
    }
    if (word.starts_with("--")) {
      judge_flag(*command, path, word);
    } else if (command->get_require_subcommand_min() > 0 && !word.starts_with("-")) {
      const CLI::App* const below = find_command(*command, word);
      if (below == nullptr) {
        std::string what = "\"" + std::string(word) + "\": " + path + " has no such command";
        what.append(meant_text(word, commands_of(*command)));
        throw Failure(Exit::kBadInput, what.append(": try ").append(path).append(" --help"));
      }
      command = below;
      path.append(" ").append(word);
    }
  }
}

}  // namespace stof::host
