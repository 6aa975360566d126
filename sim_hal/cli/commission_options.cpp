#include "options.h"

namespace berth
{

namespace
{

/* One value each time, and help that does not promise several. */
void add_repeated(CLI::App &command, const char *name, std::vector<std::string> &values, const char *meaning,
                  const char *value)
{
    command.add_option(name, values, meaning)
        ->type_name(value)
        ->option_text(value)
        ->take_all()
        ->allow_extra_args(false);
}

} // namespace

void add_commission_options(CLI::App &command, commission_arguments &arguments)
{
    add_rig_options(command, arguments);
    CLI::Option *const stage =
        command
            .add_option("--stage", arguments.stage,
                        "the stage to run: watch, tare, step, shadow, ramp or run; default: say how far it has come")
            ->check(CLI::IsMember({"watch", "tare", "step", "shadow", "ramp", "run"}).description(""))
            ->type_name("STAGE");
    CLI::Option *const waive =
        command.add_option("--waive", arguments.waive, "go on without this stage; needs --because")
            ->check(CLI::IsMember({"watch", "tare", "step", "shadow", "ramp", "run"}).description(""))
            ->type_name("STAGE")
            ->excludes(stage);
    command.add_option("--because", arguments.because, "why the stage is waived, for the record")
        ->type_name("TEXT")
        ->needs(waive);
    add_repeated(
        command, "--hardware", arguments.hardware,
        "what is really so of the simulated hardware, apart from what the rig file says; may be given again",
        "KEY=VALUE");
    add_repeated(
        command, "--pose", arguments.poses,
        "tare: where gravity points in the sensor's axes, for a standstill in this pose; may be given again",
        "X,Y,Z");
    add_repeated(command, "--log", arguments.logs,
                 "judge this log of `berth-target --stage` instead of the simulated rig; one for each --pose",
                 "FILE");
    command.add_option("--ramp-s", arguments.ramp_s, "ramp: time in which the feedback rises from 0 to 1")
        ->check(is_within(1.0, 3600.0))
        ->type_name("S")
        ->capture_default_str();
    command
        .add_option("--margin", arguments.margin,
                    "damping ratio that the predicted loop must keep; the ramp ends where it falls below")
        ->check(is_within(0.0, 1.0))
        ->type_name("RATIO")
        ->capture_default_str();
    command.add_option("--record", arguments.record, "the record of the stages; default: record.json in the folder")
        ->check(is_named("a file needs a name"))
        ->type_name("FILE");
    command
        .add_option("--out", arguments.out_folder,
                    "folder for record, logs, proposal.toml and page; default: build/commissioning/RIG")
        ->check(is_named("a folder needs a name"))
        ->type_name("DIR");
}

} // namespace berth
