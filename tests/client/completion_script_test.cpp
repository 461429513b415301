#include "client/terminal/completion_script.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace creepctl {
namespace {

/// A program with every kind of word.
class CompletionScript : public ::testing::Test {
 protected:
  CompletionScript() {
    CLI::App* plot = app_.add_subcommand("plot", "It's a plot");
    plot->add_option("DIR", word_, "Where")->required();
    plot->add_option("--format", word_, "Kind")->check(CLI::IsMember({"svg", "png"}));
    plot->add_option("--secret", word_, "Hidden")->group("");
    CLI::App* show = app_.add_subcommand("checkpoint", "Group")->add_subcommand("show", "Shows");
    show->add_flag("--json", flag_, "Print [JSON]: all");
    app_.add_subcommand("pause", "Pauses")->add_option("ID", word_, "Job");
    script_ = ::testing::TempDir() + "completion-" + std::to_string(::getpid());
  }
  ~CompletionScript() override { std::remove(script_.c_str()); }

  /// What a shell prints that was given the script as a file, whose name stands for {}.
  std::string from(const std::string& script, std::string shell_command) {
    std::ofstream(script_) << script;
    shell_command.replace(shell_command.find("{}"), 2, script_);
    std::FILE* pipe = ::popen((shell_command + " 2>&1").c_str(), "r");
    std::array<char, 4096> buffer;
    const std::size_t size = std::fread(buffer.data(), 1, buffer.size(), pipe);
    ::pclose(pipe);
    return std::string(buffer.data(), size);
  }

  std::string bash(const std::string& words) {
    return from(
        bash_completion(command_words(app_)),
        "bash -c 'creepctl() { echo job-1 job-2; }; timeout() { shift; \"$@\"; }; source {}; COMP_WORDS=(" +
            words + "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _creepctl; echo ${COMPREPLY[@]}'");
  }

  CLI::App app_{"Program", "creepctl"};
  std::string word_;
  bool flag_ = false;
  std::string script_;
};

TEST_F(CompletionScript, BashOffersCommandsOptionsChoicesAndJobIds) {
  EXPECT_EQ(bash("creepctl p"), "plot pause\n");
  EXPECT_EQ(bash("creepctl checkpoint \"\""), "show\n");
  EXPECT_EQ(bash("creepctl checkpoint show --j"), "--json\n");
  EXPECT_EQ(bash("creepctl plot --format \"\""), "svg png\n");
  EXPECT_EQ(bash("creepctl plot --"), "--help --format\n");  // not the hidden one
  EXPECT_EQ(bash("creepctl pause job-2"), "job-2\n");
}

TEST_F(CompletionScript, ZshAndFishTakeTheirScripts) {
  if (std::system("command -v zsh >/dev/null") == 0) {
    EXPECT_EQ(from(zsh_completion(command_words(app_)), "zsh -n {}"), "");
  }
  if (std::system("command -v fish >/dev/null") == 0) {
    EXPECT_EQ(
        from(fish_completion(command_words(app_)), "fish -c 'source {}; complete -C\"creepctl plot --f\"'"),
        "--format\tKind\n");
  }
}

}  // namespace
}  // namespace creepctl
