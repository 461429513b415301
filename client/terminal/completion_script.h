// Shell completion, written from the tree of commands itself, so that it cannot fall behind. Pure functions.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace creepctl {

/// What a word of the command line can be.
enum class WordKind { kFile, kJobId, kOther };

struct OptionWords {
  std::vector<std::string> names;  ///< "--out", "-f"
  std::string description;
  bool takes_value = false;
  WordKind value = WordKind::kFile;
  std::vector<std::string> choices;  ///< of the value; empty: not a fixed set
};

struct CommandWords {
  std::string name;  ///< with its group: "checkpoint show"; "" for the program
  std::string description;
  std::vector<OptionWords> options;
  WordKind positional = WordKind::kOther;
  std::vector<std::string> positional_choices;
  std::vector<CommandWords> commands;
};

/// The visible options and commands below `app`. A positional called ID... is a job id.
CommandWords command_words(const CLI::App& app, const std::string& name = "");

/// Scripts to be sourced; each asks `creepctl ls --quiet` for job ids.
std::string bash_completion(const CommandWords& root);
std::string zsh_completion(const CommandWords& root);
std::string fish_completion(const CommandWords& root);

}  // namespace creepctl
