#include "options.h"

namespace berth
{

void add_live_options(CLI::App &command, live_arguments &arguments)
{
    command.add_option("RIG", arguments.what,
                       "a rig, which is simulated, a log, or the folder of one run; shown at the pace of the clock");
    command
        .add_option(
            "--from", arguments.source,
            "show what `berth-target --live` sends from this address; the port is one of this computer, 8767 "
            "unless stated")
        ->check(is_named("--from needs the target's address, as 192.168.1.30"))
        ->type_name("ADDRESS[:PORT]");
    command.add_option("--rig", arguments.rig, "with --from: the rig that runs there, for its delay budget")
        ->check(is_named("--rig needs a shipped rig or a rig file"))
        ->type_name("RIG");
    command.add_option("--robot", arguments.robot, "robot preset or its file, in the place of the rig's robot")
        ->type_name("NAME");
    add_set_option(command, arguments.overrides);
    command.add_option("--speed", arguments.speed, "times real time, from 0.01 to 1000")
        ->check(is_within(0.01, 1000.0))
        ->capture_default_str()
        ->type_name("FACTOR");
    command
        .add_option("--bind", arguments.bind,
                    "address of this computer at which browsers and Foxglove are served; the standard is this "
                    "computer alone")
        ->check(is_named("--bind needs an address of this computer"))
        ->capture_default_str()
        ->type_name("ADDRESS");
    command.add_option("--port", arguments.port, "of page and Foxglove; 0: any that is free")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str()
        ->type_name("PORT");
    command
        .add_option("--plotjuggler", arguments.plotjuggler,
                    "also send each sample as JSON to PlotJuggler's UDP server")
        ->check(is_named("--plotjuggler needs an address, as 127.0.0.1:9870"))
        ->type_name("ADDRESS:PORT");
    command
        .add_option("--out", arguments.out_folder,
                    "folder of the marked events and of a simulated run's log; default: beside a log, else in "
                    "build/live")
        ->type_name("DIR");
    command.add_flag("--end", arguments.end, "end with the run or the log; default: until Ctrl-C");
}

} // namespace berth
