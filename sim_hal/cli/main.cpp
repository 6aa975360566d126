/* The host command `berth`. */
#include <algorithm>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iterator>
#include <limits>
#include <new>
#include <optional>
#include <sstream>
#include <unistd.h>

#include "../../hal/version.h"
#include "../rths/controller.h"
#include "colour.h"
#include "commands.h"
#include "completion.h"
#include "options.h"
#include "run_folder.h"
#include "terminal.h"
#include "usage_error.h"

namespace
{

constexpr int exit_usage_or_input = 2;

/* An empty text is no choice, as from a shell's variable that is not set. */
void refuse_empty_values(CLI::App &app)
{
    for (CLI::App *command : app.get_subcommands({})) {
        for (CLI::Option *option : command->get_options()) {
            if (option->nonpositional() && option->get_items_expected_max() > 0) {
                option->check(berth::is_named("needs a value"));
            }
        }
    }
}

/* Not files, scripts and JSON, which other programs read and people copy. */
bool prints_prose(const std::vector<std::string> &words)
{
    const auto has = [&](const char *word) { return std::find(words.begin(), words.end(), word) != words.end(); };
    if (words.empty() || has("--help") || has("-h")) {
        return true;
    }
    static const char *const makes_files[] = {"schema", "completion", "man", "arm"};
    const bool makes_file =
        std::find(std::begin(makes_files), std::end(makes_files), words[0]) != std::end(makes_files);
    const bool prints_preset = words[0] == "robots" && words.size() > 1;
    return !makes_file && !prints_preset && !has("--json") && !has("--print-config");
}

/* The words behind the program's name; `help run` is `run --help`, as users of other programs write it. */
std::vector<std::string> words_of(int argc, char **argv)
{
    std::vector<std::string> words(argv + 1, argv + argc);
    if (!words.empty() && words.front() == "help") {
        words.erase(words.begin());
        words.emplace_back("--help");
    }
    return words;
}

int run(const char *program, const std::vector<std::string> &words)
{
    CLI::App app{"berth: a real-time hybrid simulator, here against its simulated rig"};
    app.set_version_flag("--version", std::string("berth ") + berth::release + " (" + berth::version() + ")");
    app.require_subcommand(1);
    int exit_code = 0;

    berth::run_arguments run;
    CLI::App *run_app = app.add_subcommand("run", "run the loop against the simulated rig");
    berth::add_rig_options(*run_app, run);
    run_app
        ->add_option("--profile", run.profile_file,
                     "operator follows this CSV file (column: --set profile.column=NAME)")
        ->type_name("FILE")
        ->check(berth::is_named("a file needs a name"));
    berth::add_jitter_option(*run_app, run.jitter_file);
    berth::add_run_folder_options(*run_app, run);
    run_app->add_flag("--no-log", run.no_log, "write no files");
    berth::add_check_options(*run_app, run);
    run_app
        ->add_flag("--no-advice", run.no_advice,
                   "leave out margin, advice and the estimate of accuracy, which may take seconds: for many runs")
        ->excludes(run_app->get_option("--margin-ms"));
    run_app->add_flag("--print-config", run.print_config, "print the resolved rig and stop");
    run_app->callback([&] { exit_code = berth::run_command(run); });

    std::string log;
    bool json = false;
    CLI::App *replay_app =
        app.add_subcommand("replay", "feed a log's inputs through the firmware again and compare");
    replay_app->add_option("LOG", log, berth::log_meaning)->required();
    replay_app->add_flag("--json", json, "print one JSON object and nothing else");
    replay_app->callback([&] { exit_code = berth::replay_command(berth::log_of(log), json); });

    CLI::App *summary_app = app.add_subcommand("summary", "tell from a log what `berth run` told after the run");
    summary_app->add_option("LOG", log, berth::log_meaning)->required();
    summary_app->add_flag("--json", json, "print one JSON object and nothing else");
    summary_app->callback([&] { exit_code = berth::summary_command(berth::log_of(log), json); });

    CLI::App *candump_app =
        app.add_subcommand("candump", "write a log's frames as candump -L text, one file per bus");
    candump_app->add_option("LOG", log, berth::log_meaning)->required();
    candump_app->add_flag("--json", json, "print one JSON object and nothing else");
    candump_app->callback([&] { exit_code = berth::candump_command(berth::log_of(log), json); });

    berth::export_arguments exported;
    CLI::App *export_app = app.add_subcommand("export", "write a log for other programs");
    export_app->add_option("LOG", exported.log, berth::log_meaning)->required();
    export_app->add_flag("--csv", exported.csv, "one file a topic");
    export_app->add_flag("--parquet", exported.parquet, "one file a topic");
    export_app->add_flag("--mcap", exported.mcap, "one file, with schemas, as Foxglove opens it");
    export_app->callback([&] { exit_code = berth::export_command(exported); });

    berth::rig_arguments deadtime;
    CLI::App *deadtime_app = app.add_subcommand("deadtime", "measure command to motion from a step of the setpoint");
    berth::add_rig_options(*deadtime_app, deadtime);
    deadtime_app->callback([&] { exit_code = berth::deadtime_command(deadtime); });

    berth::varying_arguments eigen;
    CLI::App *eigen_app = app.add_subcommand(
        "eigen", "eigenvalues of the loop over one period, and what they mean; Lyapunov exponent of a loop that "
                 "changes from tick to tick");
    berth::add_varying_options(
        *eigen_app, eigen,
        "length of the sequence that the Lyapunov exponent is taken from; default: until it is known "
        "to 1 % or 0.001 /s");
    berth::add_check_options(*eigen_app, eigen);
    eigen_app->callback([&] { exit_code = berth::eigen_command(eigen); });

    berth::map_arguments map;
    CLI::App *map_app = app.add_subcommand("map", "largest |z| of the loop over two parameters, as a CSV file");
    berth::add_map_options(*map_app, map);
    map_app->callback([&] { exit_code = berth::map_command(map); });

    berth::limits_arguments limits;
    CLI::App *limits_app = app.add_subcommand(
        "limits", "how far each parameter of the rig may go until the loop is unstable, and what helps most");
    berth::add_rig_options(*limits_app, limits);
    berth::add_amplitude_option(*limits_app, limits);
    berth::add_check_options(*limits_app, limits);
    limits_app
        ->add_option("--change", limits.change_percent, "by how much each thing changes to see what helps most")
        ->check(CLI::Validator(CLI::Number).description(""))
        ->type_name("PERCENT")
        ->capture_default_str();
    limits_app->callback([&] { exit_code = berth::limits_command(limits); });

    berth::arm_arguments arm;
    CLI::App *arm_app =
        app.add_subcommand("arm", "print an arm on its satellite as an arm file; read one from URDF");
    berth::add_arm_options(*arm_app, arm);
    arm_app->callback([&] { exit_code = berth::arm_command(arm); });

    berth::accuracy_arguments accuracy;
    CLI::App *accuracy_app = app.add_subcommand(
        "accuracy", "how wrong fixed steps are in a berthing manoeuvre of 60 s with contact, against CVODE");
    berth::add_accuracy_options(*accuracy_app, accuracy);
    accuracy_app->callback([&] { exit_code = berth::accuracy_command(accuracy); });

    berth::reduce_arguments reduce;
    CLI::App *reduce_app = app.add_subcommand(
        "reduce", "a whole arm at a pose, and a beam, reduced to one degree of freedom, and what that leaves out");
    berth::add_reduce_options(*reduce_app, reduce);
    reduce_app->callback([&] { exit_code = berth::reduce_command(reduce); });

    berth::compensate_arguments compensate;
    CLI::App *compensate_app = app.add_subcommand(
        "compensate", "which compensation of the dead time suits the rig, and what it costs in fidelity");
    berth::add_rig_options(*compensate_app, compensate);
    berth::add_tolerance_options(*compensate_app, compensate);
    compensate_app->add_flag("--each", compensate.each, "every method on every rig that was tried");
    compensate_app->callback([&] { exit_code = berth::compensate_command(compensate); });

    berth::diagnose_arguments diagnose;
    CLI::App *diagnose_app = app.add_subcommand(
        "diagnose", "where a rig file is wrong about measured data, why, and what the model has to know");
    berth::add_diagnose_options(*diagnose_app, diagnose);
    diagnose_app->callback([&] { exit_code = berth::diagnose_command(diagnose); });

    CLI::App *effects_app = app.add_subcommand("effects", "list the effects that a diagnosis knows");
    effects_app->add_flag("--json", json, "print one JSON array and nothing else");
    effects_app->callback([&] { exit_code = berth::effects_command(json); });

    berth::rths_arguments rths;
    CLI::App *rths_app = app.add_subcommand(
        "rths", "run the public benchmark of virtual real-time hybrid simulation: criteria J1 to J9");
    berth::add_rths_options(*rths_app, rths);
    rths_app->callback([&] { exit_code = berth::rths_command(rths); });

    berth::campaign_arguments campaign;
    CLI::App *campaign_app = app.add_subcommand(
        "campaign",
        "thousands of rigs that differ as a file says, on all cores or a cluster; what makes them unstable");
    berth::add_campaign_options(*campaign_app, campaign);
    campaign_app->callback([&] { exit_code = berth::campaign_command(campaign); });

    berth::live_arguments live;
    CLI::App *live_app = app.add_subcommand(
        "live", "a loop while it runs, in a browser, Foxglove or PlotJuggler: a rig, a log or a target");
    berth::add_live_options(*live_app, live);
    live_app->callback([&] { exit_code = berth::live_command(live); });

    CLI::App *rigs_app = app.add_subcommand("rigs", "list the shipped rigs");
    rigs_app->add_flag("--json", json, "print one JSON object and nothing else");
    rigs_app->callback([&] { exit_code = berth::rigs_command(json); });

    CLI::App *schema_app =
        app.add_subcommand("schema", "print the JSON schema of rig files, for editors and programs");
    schema_app->callback([&] { exit_code = berth::schema_command(); });

    berth::init_arguments init;
    CLI::App *init_app = app.add_subcommand("init", "write a commented rig file to begin with, and its schema");
    berth::add_init_options(*init_app, init);
    init_app->callback([&] { exit_code = berth::init_command(init); });

    berth::rig_arguments checked;
    CLI::App *check_app = app.add_subcommand(
        "check", "implausible values of a rig, its delay budget and verdict; exit code 0: plausible and stable, "
                 "1: not so, 2: the rig cannot be read");
    berth::add_rig_options(*check_app, checked);
    check_app->callback([&] { exit_code = berth::check_command(checked); });

    berth::commission_arguments commission;
    CLI::App *commission_app = app.add_subcommand(
        "commission",
        "close a loop for the first time, stage by stage: watch, tare, step, shadow, ramp, run; exit code 1: the "
        "stage was not passed");
    berth::add_commission_options(*commission_app, commission);
    commission_app->callback([&] { exit_code = berth::commission_command(commission); });

    berth::compare_arguments compare;
    CLI::App *compare_app = app.add_subcommand("compare", "two runs: parameters that differ, and their verdicts");
    berth::add_compare_options(*compare_app, compare);
    compare_app->callback([&] { exit_code = berth::compare_command(compare); });

    berth::report_arguments report;
    CLI::App *report_app =
        app.add_subcommand("report", "draw a run, or a diagnosis: a page with plots to zoom, and a PNG");
    berth::add_report_options(*report_app, report);
    report_app->callback([&] { exit_code = berth::report_command(report); });

    std::string shell;
    CLI::App *completion_app =
        app.add_subcommand("completion", "print a script that completes berth's commands in a shell");
    completion_app->add_option("SHELL", shell, "the shell that sources it")
        ->required()
        ->check(CLI::IsMember(berth::shells()));
    completion_app->callback([&] { exit_code = berth::completion_command(app, shell); });

    std::string command;
    CLI::App *man_app =
        app.add_subcommand("man", "print the manual page, as `man` reads it: berth man run | man -l -");
    man_app->add_option("COMMAND", command, "the command that it is about; default: all in a line each");
    man_app->callback([&] { exit_code = berth::man_command(app, command); });

    std::string robot;
    CLI::App *robots_app = app.add_subcommand("robots", "list the robot presets for --robot, or print one");
    robots_app->add_option("NAME", robot, "a robot preset, or the path of a preset file: print it");
    robots_app->add_flag("--json", json, "print one JSON object and nothing else");
    robots_app->callback([&] { exit_code = berth::robots_command(robot, json); });

    refuse_empty_values(app);
    app.name(program);
    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
    } catch (const CLI::ParseError &error) {
        if (error.get_exit_code() == 0) { /* --help, --version */
            std::ostringstream text;
            app.exit(error, text);
            std::fputs(text.str().c_str(), stdout);
            return 0;
        }
        const std::vector<CLI::App *> chosen = app.get_subcommands();
        std::fprintf(stderr, "%s %s; see berth %s--help\n",
                     berth::coloured(stderr, berth::ink::red, "berth:").c_str(),
                     berth::usage_error(app, error, words).c_str(),
                     chosen.empty() ? "" : (chosen.front()->get_name() + " ").c_str());
        return exit_usage_or_input;
    }
    return exit_code;
}

} // namespace

int main(int argc, char **argv)
{
    const std::vector<std::string> words = words_of(argc, argv);
    std::optional<berth::wrapped_stream> output;
    if (prints_prose(words)) {
        output.emplace(stdout, STDOUT_FILENO);
    }
    const berth::wrapped_stream errors(stderr, STDERR_FILENO);
    const std::string name = berth::coloured(stderr, berth::ink::red, "berth:");
    try {
        const int exit_code = run(argv[0], words);
        if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
            throw berth::input_error("standard output cannot be written; is its disk full?");
        }
        return exit_code;
    } catch (const berth::input_error &error) {
        std::fprintf(stderr, "%s %s\n", name.c_str(), error.what());
        return exit_usage_or_input;
    } catch (const std::bad_alloc &) {
        std::fprintf(stderr, "%s not enough memory: ask for fewer points, a shorter run or a shorter record\n",
                     name.c_str());
        return exit_usage_or_input;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s internal error: %s\n", name.c_str(), error.what());
        return 1;
    }
}
