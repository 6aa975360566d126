/* The options of the commands of `berth`, and where their values go. */
#ifndef SIM_HAL_CLI_OPTIONS_H
#define SIM_HAL_CLI_OPTIONS_H

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "commands.h"

namespace berth
{

/* An empty text is no choice, as from a shell's variable that is not set: then the advice is the message. */
CLI::Validator is_named(const std::string &advice);

/* As CLI::Range, which takes what is no number for one within. */
CLI::Validator is_within(double low, double high);

/* What a positional LOG is. */
constexpr const char *log_meaning =
    "a .ulg file written by `berth run`, the folder of one run, or a rig's name: its newest run";

void add_set_option(CLI::App &command, std::vector<std::string> &overrides);
void add_rig_options(CLI::App &command, rig_arguments &arguments);
void add_amplitude_option(CLI::App &command, rig_arguments &arguments);
void add_check_options(CLI::App &command, rig_arguments &arguments);
void add_jitter_option(CLI::App &command, std::string &jitter_file);
void add_varying_options(CLI::App &command, varying_arguments &arguments, const char *ticks);
void add_run_folder_options(CLI::App &command, run_arguments &arguments);
void add_init_options(CLI::App &command, init_arguments &arguments);
void add_commission_options(CLI::App &command, commission_arguments &arguments);
void add_compare_options(CLI::App &command, compare_arguments &arguments);
void add_report_options(CLI::App &command, report_arguments &arguments);
void add_map_options(CLI::App &command, map_arguments &arguments);
void add_arm_options(CLI::App &command, arm_arguments &arguments);
void add_accuracy_options(CLI::App &command, accuracy_arguments &arguments);
void add_reduce_options(CLI::App &command, reduce_arguments &arguments);
void add_tolerance_options(CLI::App &command, compensate_arguments &arguments);
void add_diagnose_options(CLI::App &command, diagnose_arguments &arguments);
void add_rths_options(CLI::App &command, rths_arguments &arguments);
void add_campaign_options(CLI::App &command, campaign_arguments &arguments);
void add_live_options(CLI::App &command, live_arguments &arguments);

} // namespace berth

#endif
