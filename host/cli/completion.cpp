#include "host/cli/completion.h"

#include <array>
#include <string>

#include "host/cli/config/config.h"
#include "host/cli/fault.h"
#include "host/cli/help_text.h"
#include "host/cli/output.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// Of an option that takes one of a few words: "a b c". Empty: it takes anything.
std::string values_of(const CLI::Option& option) {
  // IsMember describes itself as {a,b,c}.
  const std::string type = option.get_type_name();
  const std::size_t begin = type.rfind('{');
  const std::size_t end = type.rfind('}');
  if (begin == std::string::npos || end == std::string::npos || end < begin) {
    return {};
  }
  std::string words = type.substr(begin + 1, end - begin - 1);
  for (char& c : words) {
    c = c == ',' ? ' ' : c;
  }
  return words;
}

// What options do not tell: words of a command, and words behind one of them.
struct Known {
  const char* path;
  const char* words;
};
constexpr std::array<Known, 2> kKnownWords{
    {{"stof config", kConfigActions}, {"stof fault", "trigger: stereo: pmd:"}}};
constexpr std::array<Known, 2> kKnownBehind{
    {{"stof config preset", kPresetNames}, {"stof fault :", kFaultKinds}}};

struct Script {
  std::string paths;   // patterns of commands that lead on: "stof calib" | ...
  std::string values;  // cases: what follows a flag
  std::string words;   // cases: what may stand in a command
};

void add_command(const CLI::App& app, const std::string& path, Script& script) {
  std::string words;
  for (const CLI::App* const below : app.get_subcommands([](const CLI::App*) { return true; })) {
    const std::string name = path + " " + below->get_name();
    script.paths += (script.paths.empty() ? "\"" : " | \"") + name + "\"";
    words += below->get_name() + " ";
    add_command(*below, name, script);
  }
  std::string free;  // flags that take anything
  for (const CLI::Option* const option : app.get_options()) {
    const std::string values = values_of(*option);
    if (option->get_positional()) {
      words += values.empty() ? "" : values + " ";
    }
    for (const std::string& name : option->get_lnames()) {
      words.append("--").append(name).append(" ");
      if (option->get_items_expected_max() == 0) {
        continue;
      }
      const std::string key = printed("\"%s --%s\"", path.c_str(), name.c_str());
      if (values.empty()) {
        free.append(free.empty() ? "" : " | ").append(key);
      } else {
        script.values.append("    ")
            .append(key)
            .append(") words=\"")
            .append(values)
            .append("\" ;;\n");
      }
    }
  }
  if (!free.empty()) {
    script.values += "    " + free + ") return ;;\n";
  }
  for (const Known& known : kKnownWords) {
    words += known.path == path ? std::string(known.words) + " " : "";
  }
  words.resize(words.empty() ? 0 : words.size() - 1);
  script.words += "    \"" + path + "\") words=\"" + words + "\" ;;\n";
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  Script script;
  add_command(app, app.get_name(), script);
  for (const Known& known : kKnownBehind) {
    script.values.append(printed("    \"%s\") words=\"%s\" ;;\n", known.path, known.words));
  }
  const std::string& name = app.get_name();
  // Bash splits --flag=value at the =, which is a word of its own then, and pmd:vanish at the
  // colon.
  return "# bash completion of " + name + ", made by: " + name + " completion bash\n_" + name +
         "() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} path=" +
         name +
         " words= i\n"
         "  COMPREPLY=()\n"
         "  if [ \"$current\" = = ]; then\n"
         "    current=\n"
         "  elif [ \"$before\" = = ]; then\n"
         "    before=${COMP_WORDS[COMP_CWORD - 2]}\n"
         "  fi\n"
         "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
         "    case \"$path ${COMP_WORDS[i]}\" in\n"
         "    " +
         script.paths +
         ") path=\"$path ${COMP_WORDS[i]}\" ;;\n"
         "    esac\n"
         "  done\n"
         "  if [ \"$path $current\" = \"stof fault :\" ]; then\n"
         "    before=: current=\n"
         "  fi\n"
         "  case \"$path $before\" in\n" +
         script.values +
         "  esac\n"
         "  if [ -z \"$words\" ]; then\n"
         "    case \"$path\" in\n" +
         script.words +
         "    esac\n"
         "  fi\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  case \"${COMPREPLY[*]}\" in\n"
         "    *:) compopt -o nospace 2>/dev/null ;;\n"
         "  esac\n"
         "}\n"
         "complete -o default -F _" +
         name + " " + name + "\n";
}

void add_completion(CLI::App& app, CompletionOptions& options) {
  CLI::App& command =
      *app.add_subcommand("completion", "Print what completes commands and flags in a shell");
  show_example(command, "source <(stof completion bash)",
               "Packages install it; zsh takes it after: autoload -U bashcompinit; bashcompinit\n"
               "Ends with 0 (done), 1 (the output cannot be written) or 2 (bad input).");
  command.add_option("SHELL", options.shell, "bash")->required()->check(CLI::IsMember({"bash"}));
  command.callback([&app] { say_text(bash_completion(app)); });
}

}  // namespace stof::host
