#include "tools/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>

#include "base/text.h"
#include "effects/registry.h"
#include "export/export_target.h"
#include "import/import_format.h"
#include "simulation/catalogue.h"

namespace mm {
namespace {

/// What a validator adds to a type's name: the words of CLI::IsMember between braces, bounds between
/// brackets.
std::string addedTo(const std::string& type, const std::string& open, char close) {
  const std::size_t from = type.find(open), to = type.find(close);
  if (from == std::string::npos || to == std::string::npos) return {};
  return type.substr(from + open.size(), to - from - open.size());
}

/// What CLI11 does not know of an option or a positional: words that it takes beside others, its files.
struct Values {
  std::string name;  // "--machine"; of a positional its name
  std::vector<std::string> known;
  std::string ending;
};

std::vector<Values> knownValues() {
  std::vector<std::string> effects, formats, hidden = {"random"};
  for (const EffectType& type : effectRegistry()) effects.push_back(type.type);
  for (const ImportFormat& format : importFormats()) formats.emplace_back(format.name);
  for (const SourceKind& kind : sourceKinds()) hidden.push_back(kind.type);
  return {{"--machine", {"three_axis", "five_axis"}, "urdf"},
          {"--method", {"least_squares", "staged_mutation", "niching"}, ""},
          {"--to", exportTargetNames(), ""},
          {"--format", formats, ""},
          {"--hide", hidden, ""},
          {"type", effects, ""},
          {"--model", {}, "yaml"},
          {"--calibration", {}, "yaml"},
          {"calibration", {}, "yaml"},
          {"--plan", {}, "yaml"},
          {"plan", {}, "yaml"},
          {"--artifact", {}, "yaml"},
          {"--columns", {}, "yaml"},
          {"manifest", {}, "yaml"},
          {"bag", {}, "bag"},
          {"--session", {}, "bag"}};
}

CommandOption toOption(const CLI::Option& option) {
  CommandOption o;
  for (const std::string& name : option.get_snames()) o.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) o.names.push_back("--" + name);
  o.description = option.get_description();
  o.standard = option.get_default_str();
  o.group = option.get_group();
  o.required = option.get_required();
  o.takesValue = option.get_expected_max() > 0;
  const std::string type = option.get_type_name();
  std::istringstream words(addedTo(type, "{", '}'));
  for (std::string word; std::getline(words, word, ',');) o.words.push_back(word);
  o.bounds = addedTo(type, ":[", ']');
  o.placeholder = o.names.empty() ? option.get_name() : type.substr(0, type.find(':'));
  static const std::vector<Values> values = knownValues();
  if (!o.words.empty()) return o;
  for (const Values& v : values)
    if (o.names.empty() ? v.name == o.placeholder
                        : std::find(o.names.begin(), o.names.end(), v.name) != o.names.end()) {
      o.known = v.known;
      o.ending = v.ending;
    }
  return o;
}

void collect(const CLI::App& app, const std::string& before, std::vector<Command>& all) {
  for (const CLI::App* sub : app.get_subcommands(nullptr)) {
    const std::string name = before + sub->get_name();
    if (!sub->get_subcommands(nullptr).empty()) {
      collect(*sub, name + " ", all);
      continue;
    }
    Command command;
    command.name = name;
    command.description = sub->get_description();
    command.footer = sub->get_footer();
    for (const CLI::Option* option : sub->get_options()) {
      const CommandOption o = toOption(*option);
      (o.names.empty() ? command.positionals : command.options).push_back(o);
    }
    all.push_back(command);
  }
}

std::string namesOf(const std::vector<CommandOption>& options) {
  std::string text;
  for (const CommandOption& o : options)
    for (const std::string& name : o.names) text += (text.empty() ? "" : " ") + name;
  return text;
}

/// "machine new" as a name of a function or a page.
std::string dashed(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

const std::vector<std::string>& wordsOf(const CommandOption& o) {
  return o.words.empty() ? o.known : o.words;
}

/// What the script proposes for a value; nothing known: any file, by the shell itself.
std::string takenInBash(const CommandOption& o) {
  if (wordsOf(o).empty() && o.ending.empty()) return "return";
  return "words='" + joined(wordsOf(o), " ") + "' ending='" + o.ending + "'";
}

/// The same as an action of zsh's _arguments.
std::string takenInZsh(const CommandOption& o) {
  const std::string words = joined(wordsOf(o), " ");
  const std::string files = o.ending.empty() ? "_files" : "_files -g \"*." + o.ending + "\"";
  if (words.empty()) return files;
  return o.ending.empty() ? "(" + words + ")" : "{compadd " + words + "; " + files + "}";
}

std::string firstWord(const std::string& name) { return name.substr(0, name.find(' ')); }

/// Each first word of a command that has second ones, and these.
std::vector<std::pair<std::string, std::string>> secondWords(const CLI::App& app) {
  std::vector<std::pair<std::string, std::string>> nested;
  for (const Command& c : commandsOf(app)) {
    const std::string word = firstWord(c.name);
    if (c.name == word) continue;
    if (nested.empty() || nested.back().first != word) nested.push_back({word, ""});
    nested.back().second += (nested.back().second.empty() ? "" : " ") + c.name.substr(word.size() + 1);
  }
  return nested;
}

/// Between single quotes of a shell, and for zsh's _arguments.
std::string quotedForZsh(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      out += std::string("\\") + c;
    else
      out += c == '\n' ? ' ' : c;
  }
  return out;
}

/// Text for troff: nothing in it is a request or an escape.
std::string forTroff(const std::string& text) {
  std::string out;
  bool lineStart = true;
  for (const char c : text) {
    if (lineStart && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    lineStart = c == '\n';
  }
  return out;
}

void titleOf(std::ostream& out, const std::string& page, const std::string& version,
             const std::string& what) {
  std::string upper = page;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  out << ".TH " << upper << " 1 \"\" \"measuring_machine " << version
      << "\" \"measuring_machine\"\n.SH NAME\n"
      << forTroff(page) << " \\- " << forTroff(what) << "\n";
}

void optionsOf(std::ostream& out, const std::vector<CommandOption>& options) {
  std::string group;
  for (const CommandOption& o : options) {
    if (o.group.empty()) continue;  // hidden
    if (o.group != group && o.group != "Options" && o.group != "Positionals")
      out << ".SS " << forTroff(o.group) << "\n";
    group = o.group;
    out << ".TP\n\\fB" << forTroff(o.names.empty() ? o.placeholder : joined(o.names, ", ")) << "\\fR";
    if (!o.names.empty() && o.takesValue) out << " \\fI" << forTroff(o.placeholder) << "\\fR";
    out << "\n" << forTroff(o.description);
    if (!o.words.empty()) out << " {" << forTroff(joined(o.words, ", ")) << "}";
    if (!o.bounds.empty()) out << ", " << forTroff(o.bounds);
    if (!o.standard.empty()) out << " [" << forTroff(o.standard) << "]";
    if (o.required) out << " (required)";
    out << "\n";
  }
}

}  // namespace

std::vector<Command> commandsOf(const CLI::App& app) {
  std::vector<Command> all;
  collect(app, "", all);
  return all;
}

std::vector<CommandOption> commonOptions(const CLI::App& app) {
  std::vector<CommandOption> options;
  for (const CLI::Option* option : app.get_options())
    if (!option->get_lnames().empty()) options.push_back(toOption(*option));
  return options;
}

std::string bashCompletion(const CLI::App& app) {
  std::vector<std::string> first;
  std::ostringstream cases;
  for (const Command& c : commandsOf(app)) {
    const std::string word = firstWord(c.name);
    if (first.empty() || first.back() != word) first.push_back(word);
    cases << "    '" << c.name << "')\n      options='" << namesOf(c.options) << "'\n";
    std::ostringstream values;
    for (const CommandOption& o : c.options)
      if (o.takesValue) values << "        " << joined(o.names, "|") << ") " << takenInBash(o) << " ;;\n";
    if (!values.str().empty()) cases << "      case \"$previous\" in\n" << values.str() << "      esac\n";
    for (const CommandOption& o : c.positionals)
      if (!wordsOf(o).empty() || !o.ending.empty())
        cases << "      [[ -n \"$words$ending\" ]] || { " << takenInBash(o) << "; }\n";
    cases << "      ;;\n";
  }
  std::ostringstream out;
  out << "# Completion of mm for bash: source <(mm completion bash)\n"
         "_mm() {\n"
         "  local current=\"${COMP_WORDS[COMP_CWORD]}\" previous=\"${COMP_WORDS[COMP_CWORD-1]}\" "
         "command=\"${COMP_WORDS[1]}\"\n"
         "  local options='' words='' ending=''\n"
         "  COMPREPLY=()\n"
         "  if ((COMP_CWORD == 1)); then\n"
         "    COMPREPLY=($(compgen -W '"
      << joined(first, " ") << " " << namesOf(commonOptions(app))
      << "' -- \"$current\"))\n"
         "    return\n"
         "  fi\n"
         "  case \"$command\" in\n";
  for (const auto& [word, seconds] : secondWords(app))
    out << "    " << word << ")\n      if ((COMP_CWORD == 2)); then\n        COMPREPLY=($(compgen -W '"
        << seconds
        << "' -- \"$current\"))\n        return\n      fi\n      command+=\" ${COMP_WORDS[2]}\"\n      ;;\n";
  out << "  esac\n"
         "  case \"$command\" in\n"
      << cases.str()
      << "  esac\n"
         "  if [[ \"$current\" == -* ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$options\" -- \"$current\"))\n"
         "  else\n"
         "    COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "    if [[ -n \"$ending\" ]]; then\n"
         "      local IFS=$'\\n'\n"
         "      compopt -o filenames 2>/dev/null\n"
         "      COMPREPLY+=($(compgen -d -- \"$current\") $(compgen -f -X \"!*.$ending\" -- \"$current\"))\n"
         "    fi\n"
         "  fi\n"
         "}\n"
         "complete -o default -o bashdefault -F _mm mm\n";
  return out.str();
}

std::string zshCompletion(const CLI::App& app) {
  const auto valueOf = [](const CommandOption& o) {
    const std::string what = quotedForZsh(o.placeholder.empty() ? "value" : o.placeholder);
    return ":" + what + ":" + takenInZsh(o);
  };
  std::ostringstream commands, cases;
  std::string last;
  for (const Command& c : commandsOf(app)) {
    const std::string word = firstWord(c.name);
    if (word != last)
      commands << "    '" << quotedForZsh(word) << ":" << quotedForZsh(c.description) << "'\n";
    last = word;
    cases << "    '" << c.name << "')\n      _arguments";
    for (const CommandOption& o : c.options)
      for (const std::string& name : o.names)
        cases << " \\\n        '*" << name << "[" << quotedForZsh(o.description) << "]"
              << (o.takesValue ? valueOf(o) : "") << "'";
    for (const CommandOption& o : c.positionals) cases << " \\\n        '" << valueOf(o) << "'";
    cases << "\n      ;;\n";
  }
  std::ostringstream nested;
  for (const auto& [word, seconds] : secondWords(app))
    nested << "  if [[ \"$command\" == " << word
           << " ]]; then\n    if ((CURRENT == 3)); then\n      compadd -- " << seconds
           << "\n      return\n    fi\n    command+=\" ${words[3]}\"\n    shift words\n    ((CURRENT--))\n  "
              "fi\n";
  std::ostringstream out;
  out << "#compdef mm\n"
         "# Completion of mm for zsh: mm completion zsh > a folder of $fpath/_mm\n"
         "_mm() {\n"
         "  local -a commands\n"
         "  commands=(\n"
      << commands.str()
      << "  )\n"
         "  if ((CURRENT == 2)); then\n"
         "    _describe command commands\n"
         "    return\n"
         "  fi\n"
         "  local command=\"${words[2]}\"\n"
      << nested.str()
      << "  shift words\n"
         "  ((CURRENT--))\n"
         "  case \"$command\" in\n"
      << cases.str()
      << "  esac\n"
         "}\n"
         "if [[ \"${funcstack[1]}\" == _mm ]]; then _mm \"$@\"; else compdef _mm mm; fi\n";
  return out.str();
}

std::string manualPage(const CLI::App& app, const std::string& version) {
  std::ostringstream out;
  titleOf(out, "mm", version, app.get_description());
  out << ".SH SYNOPSIS\n\\fBmm\\fR \\fIcommand\\fR [\\fIoptions\\fR]\n.SH COMMANDS\n";
  for (const Command& c : commandsOf(app))
    out << ".TP\n\\fB" << forTroff("mm-" + dashed(c.name)) << "\\fR(1)\n" << forTroff(c.description) << "\n";
  out << ".SH OPTIONS\n";
  optionsOf(out, commonOptions(app));
  out << ".SH NOTES\n.nf\n" << forTroff(app.get_footer()) << "\n.fi\n";
  return out.str();
}

std::string manualPage(const Command& c, const std::string& version) {
  std::ostringstream out;
  titleOf(out, "mm-" + dashed(c.name), version, c.description);
  out << ".SH SYNOPSIS\n\\fBmm " << forTroff(c.name) << "\\fR";
  for (const CommandOption& o : c.positionals)
    out << (o.required ? " " : " [") << "\\fI" << forTroff(o.placeholder) << "\\fR"
        << (o.required ? "" : "]");
  for (const CommandOption& o : c.options)
    if (o.required) out << " " << forTroff(o.names.front()) << " \\fI" << forTroff(o.placeholder) << "\\fR";
  out << " [\\fIoptions\\fR]\n.SH OPTIONS\n";
  optionsOf(out, c.positionals);
  optionsOf(out, c.options);
  if (!c.footer.empty()) out << ".SH NOTES\n.nf\n" << forTroff(c.footer) << "\n.fi\n";
  out << ".SH SEE ALSO\n\\fBmm\\fR(1)\n";
  return out.str();
}

}  // namespace mm
