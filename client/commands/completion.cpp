#include "client/commands/commands.h"

#include <cstdio>
#include <memory>

#include "client/terminal/completion_script.h"
#include "client/terminal/exit_codes.h"

namespace creepctl {

void add_completion(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("completion", "Prints the completion script of a shell");
  auto shell = std::make_shared<std::string>();
  command->add_option("SHELL", *shell, "The shell")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->footer(
      "Example:\n  source <(creepctl completion bash)\n  creepctl completion fish > "
      "~/.config/fish/completions/creepctl.fish");
  command->callback([&app, shell, &exit_code] {
    const CommandWords words = command_words(app);
    const std::string script = *shell == "bash"  ? bash_completion(words)
                               : *shell == "zsh" ? zsh_completion(words)
                                                 : fish_completion(words);
    exit_code = std::fputs(script.c_str(), stdout) >= 0 && std::fflush(stdout) == 0 ? kOk : kFailed;
  });
}

}  // namespace creepctl
