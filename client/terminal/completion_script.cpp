#include "client/terminal/completion_script.h"

#include <algorithm>

namespace creepctl {
namespace {

/// A daemon that does not answer must not block the shell.
constexpr const char* kListIds = "timeout 2 creepctl ls --quiet 2>/dev/null";

/// The members of a CLI::IsMember check, which CLI11 gives only as text: "TEXT:{svg,png}".
std::vector<std::string> choices_of(const std::string& type_name) {
  const auto begin = type_name.find('{');
  const auto end = type_name.rfind('}');
  std::vector<std::string> choices;
  if (begin == std::string::npos || end == std::string::npos) return choices;
  for (std::size_t at = begin + 1; at <= end;) {
    const std::size_t comma = std::min(type_name.find(',', at), end);
    choices.push_back(type_name.substr(at, comma - at));
    at = comma + 1;
  }
  return choices;
}

WordKind positional_kind(const std::string& name) {
  if (name.starts_with("ID")) return WordKind::kJobId;
  return name == "JOB" || name == "FILE" || name == "DIR" || name == "PATH" ? WordKind::kFile
                                                                            : WordKind::kOther;
}

std::string joined(const std::vector<std::string>& words, const char* separator = " ") {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

/// `text` between single quotes; a quote inside is written '\''.
std::string in_quotes(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::vector<std::string> names_of(const std::vector<CommandWords>& commands) {
  std::vector<std::string> names;
  names.reserve(commands.size());
  for (const CommandWords& command : commands) {
    names.push_back(command.name.substr(command.name.find_last_of(' ') + 1));
  }
  return names;
}

template <typename Visit>
void visit_all(const CommandWords& command, const Visit& visit) {
  visit(command);
  for (const CommandWords& inner : command.commands) visit_all(inner, visit);
}

std::string bash_case(const CommandWords& command) {
  std::vector<std::string> options;
  for (const OptionWords& option : command.options) {
    options.insert(options.end(), option.names.begin(), option.names.end());
  }
  std::vector<std::string> words = names_of(command.commands);
  words.insert(words.end(), command.positional_choices.begin(), command.positional_choices.end());
  std::string text = "    " + in_quotes(command.name) + ") options=" + in_quotes(joined(options)) +
                     " words=" + in_quotes(joined(words));
  if (command.positional == WordKind::kJobId) text += " ids=yes";
  return text + " ;;\n";
}

std::string bash_value_cases(const CommandWords& command) {
  std::string text;
  for (const OptionWords& option : command.options) {
    if (!option.takes_value) continue;
    std::vector<std::string> patterns;
    for (const std::string& name : option.names) patterns.push_back(in_quotes(command.name + " " + name));
    text += "    " + joined(patterns, "|") + ") ";
    if (!option.choices.empty()) {
      text += "COMPREPLY=($(compgen -W " + in_quotes(joined(option.choices)) + " -- \"$word\")); ";
    }
    text += "return ;;\n";  // nothing: bash offers files
  }
  return text;
}

/// For zsh's _arguments, where [ ] : delimit.
std::string zsh_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

const char* zsh_action(WordKind kind) {
  return kind == WordKind::kJobId ? "_creepctl_ids" : kind == WordKind::kFile ? "_files" : " ";
}

std::string zsh_arguments(const CommandWords& command) {
  std::string text;
  for (const OptionWords& option : command.options) {
    for (const std::string& name : option.names) {
      std::string spec = name + "[" + zsh_text(option.description) + "]";
      if (option.takes_value) {
        spec += option.choices.empty() ? std::string(":value:") + zsh_action(option.value)
                                       : ":value:(" + joined(option.choices) + ")";
      }
      text += " \\\n        " + in_quotes(spec);
    }
  }
  if (!command.positional_choices.empty()) {
    text += " \\\n        " + in_quotes("1:value:(" + joined(command.positional_choices) + ")");
  } else if (!command.commands.empty()) {
    text += " \\\n        " + in_quotes("1:command:(" + joined(names_of(command.commands)) + ")");
  } else if (command.positional != WordKind::kOther) {
    text += " \\\n        " + in_quotes(std::string("*:argument:") + zsh_action(command.positional));
  }
  return text;
}

/// The condition under which fish offers words of the command.
std::string fish_condition(const CommandWords& command) {
  if (command.name.empty()) return "__fish_use_subcommand";
  const auto space = command.name.find(' ');
  std::string condition = "__fish_seen_subcommand_from " + command.name.substr(0, space);
  if (space != std::string::npos) {
    condition += "; and __fish_seen_subcommand_from " + command.name.substr(space + 1);
  } else if (!command.commands.empty()) {
    condition += "; and not __fish_seen_subcommand_from " + joined(names_of(command.commands));
  }
  return condition;
}

std::string fish_lines(const CommandWords& command) {
  const std::string start = "complete -c creepctl -n " + in_quotes(fish_condition(command));
  std::string text;
  const std::vector<std::string> names = names_of(command.commands);
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += start + " -f -a " + names[i] + " -d " + in_quotes(command.commands[i].description) + "\n";
  }
  if (!command.positional_choices.empty()) {
    text += start + " -f -a " + in_quotes(joined(command.positional_choices)) + "\n";
  }
  if (command.positional == WordKind::kJobId) {
    text += start + " -f -a " + in_quotes(std::string("(") + kListIds + ")") + "\n";
  }
  for (const OptionWords& option : command.options) {
    std::string line = start;
    for (const std::string& name : option.names) {
      line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    }
    if (option.takes_value) line += " -r";
    if (!option.choices.empty()) line += " -f -a " + in_quotes(joined(option.choices));
    text += line + " -d " + in_quotes(option.description) + "\n";
  }
  return text;
}

}  // namespace

CommandWords command_words(const CLI::App& app, const std::string& name) {
  CommandWords command;
  command.name = name;
  command.description = app.get_description();
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    const std::vector<std::string> choices = choices_of(option->get_type_name());
    if (option->get_positional()) {
      command.positional = positional_kind(option->get_name());
      command.positional_choices = choices;
      continue;
    }
    OptionWords words;
    words.description = option->get_description();
    words.takes_value = option->get_items_expected_max() > 0;
    words.choices = choices;
    for (const std::string& word : option->get_snames()) words.names.push_back("-" + word);
    for (const std::string& word : option->get_lnames()) words.names.push_back("--" + word);
    command.options.push_back(std::move(words));
  }
  for (const CLI::App* inner : app.get_subcommands([](const CLI::App*) { return true; })) {
    const std::string inner_name = name.empty() ? inner->get_name() : name + " " + inner->get_name();
    command.commands.push_back(command_words(*inner, inner_name));
  }
  return command;
}

std::string bash_completion(const CommandWords& root) {
  std::vector<std::string> steps;  // as they are met: "" + " run", "checkpoint" + " show"
  std::string cases, value_cases;
  visit_all(root, [&](const CommandWords& command) {
    cases += bash_case(command);
    value_cases += bash_value_cases(command);
    for (const std::string& name : names_of(command.commands)) {
      steps.push_back(in_quotes(command.name + " " + name));
    }
  });
  return "# bash completion for creepctl: source <(creepctl completion bash)\n"
         "_creepctl() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}\n"
         "  local command= options= words= ids= i\n"
         "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
         "    case \"$command ${COMP_WORDS[i]}\" in\n"
         "    " +
         joined(steps, "|") +
         ") command=${command:+$command }${COMP_WORDS[i]} ;;\n"
         "    esac\n"
         "  done\n"
         "  COMPREPLY=()\n"
         "  case \"$command $previous\" in\n" +
         value_cases +
         "  esac\n"
         "  case \"$command\" in\n" +
         cases +
         "  esac\n"
         "  if [[ $word == -* ]]; then words=$options; elif [[ -n $ids ]]; then words=$(" +
         kListIds +
         "); fi\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
         "}\n"
         "complete -o default -F _creepctl creepctl\n";
}

std::string zsh_completion(const CommandWords& root) {
  std::string described, cases;
  for (const CommandWords& command : root.commands) {
    described += "    " + in_quotes(zsh_text(command.name) + ":" + command.description) + "\n";
    cases += "    " + command.name + ")\n      _arguments" + zsh_arguments(command) + " ;;\n";
    for (const CommandWords& inner : command.commands) {
      cases += "    " + in_quotes(inner.name) + ")\n      _arguments" + zsh_arguments(inner) + " ;;\n";
    }
  }
  return "#compdef creepctl\n"
         "# zsh completion for creepctl: source <(creepctl completion zsh)\n"
         "_creepctl_ids() {\n"
         "  local -a ids\n"
         "  ids=(${(f)\"$(" +
         std::string(kListIds) +
         ")\"})\n"
         "  compadd -a ids\n"
         "}\n"
         "_creepctl() {\n"
         "  local -a commands\n"
         "  commands=(\n" +
         described +
         "  )\n"
         "  if ((CURRENT == 2)); then\n"
         "    _describe command commands\n"
         "    return\n"
         "  fi\n"
         "  local command=$words[2]\n"
         "  shift words\n"
         "  ((CURRENT--))\n"
         "  if [[ $command == checkpoint ]] && ((CURRENT > 2)); then\n"
         "    command+=\" $words[2]\"\n"
         "    shift words\n"
         "    ((CURRENT--))\n"
         "  fi\n"
         "  case $command in\n" +
         cases +
         "  esac\n"
         "}\n"
         "if [[ $funcstack[1] == _creepctl ]]; then _creepctl \"$@\"; else compdef _creepctl creepctl; fi\n";
}

std::string fish_completion(const CommandWords& root) {
  std::string text = "# fish completion for creepctl: creepctl completion fish | source\n";
  visit_all(root, [&](const CommandWords& command) { text += fish_lines(command); });
  return text;
}

}  // namespace creepctl
