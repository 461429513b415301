// The commands of creepctl, one file each. A function adds its command to `app`; the callback sets
// `exit_code`, which must outlive the parse.
#pragma once

#include <CLI/CLI.hpp>

namespace creepctl {

void add_cancel(CLI::App& app, int& exit_code);      ///< creepctl cancel ID...
void add_checkpoint(CLI::App& app, int& exit_code);  ///< creepctl checkpoint show FILE|DIR
void add_compare(CLI::App& app, int& exit_code);     ///< creepctl compare DIR...
void add_completion(CLI::App& app, int& exit_code);  ///< creepctl completion SHELL
void add_delete(CLI::App& app, int& exit_code);      ///< creepctl delete ID...
void add_doctor(CLI::App& app, int& exit_code);      ///< creepctl doctor
void add_fetch(CLI::App& app, int& exit_code);       ///< creepctl fetch ID --out DIR
void add_fork(CLI::App& app, int& exit_code);        ///< creepctl fork ID
void add_init(CLI::App& app, int& exit_code);        ///< creepctl init [FILE]
void add_logs(CLI::App& app, int& exit_code);        ///< creepctl logs ID
void add_ls(CLI::App& app, int& exit_code);          ///< creepctl ls
void add_pause(CLI::App& app, int& exit_code);       ///< creepctl pause ID...
void add_plan(CLI::App& app, int& exit_code);        ///< creepctl plan JOB.toml
void add_plot(CLI::App& app, int& exit_code);        ///< creepctl plot
void add_report(CLI::App& app, int& exit_code);      ///< creepctl report
void add_resume(CLI::App& app, int& exit_code);      ///< creepctl resume ID...
void add_run(CLI::App& app, int& exit_code);         ///< creepctl run JOB.toml --out DIR
void add_show(CLI::App& app, int& exit_code);        ///< creepctl show ID
void add_submit(CLI::App& app, int& exit_code);      ///< creepctl submit JOB.toml
void add_sweep(CLI::App& app, int& exit_code);       ///< creepctl sweep JOB
void add_validate(CLI::App& app, int& exit_code);    ///< creepctl validate JOB.toml
void add_version(CLI::App& app, int& exit_code);     ///< creepctl version
void add_wait(CLI::App& app, int& exit_code);        ///< creepctl wait ID
void add_watch(CLI::App& app, int& exit_code);       ///< creepctl watch ID

}  // namespace creepctl
