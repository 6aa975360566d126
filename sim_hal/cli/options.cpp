#include "options.h"

#include <limits>
#include <sstream>

#include "../rths/controller.h"
#include "compensation_choice.h"
#include "rig_template.h"

namespace berth
{

/* An empty text is no choice, as from a shell's variable that is not set. */
CLI::Validator is_named(const std::string &advice)
{
    return CLI::Validator([advice](const std::string &name) { return name.empty() ? advice : std::string(); }, "");
}

/* As CLI::Range, which takes what is no number for one within. */
CLI::Validator is_within(double low, double high)
{
    return CLI::Validator(
        [low, high](const std::string &text) {
            double value = 0.0;
            const bool is_number = CLI::detail::lexical_cast(text, value);
            std::ostringstream problem;
            if (!is_number || !(value >= low && value <= high)) {
                problem << "must be a number from " << low << " to " << high << " (is " << text << ")";
            }
            return problem.str();
        },
        "");
}

/* Of an option that may be given again: one value each time, and help that does not promise several. */
static CLI::Option *one_value(CLI::Option *option, const std::string &value)
{
    return option->type_name(value)->option_text(value)->take_all()->allow_extra_args(false);
}

void add_set_option(CLI::App &command, std::vector<std::string> &overrides)
{
    one_value(
        command.add_option("--set", overrides, "override a key of the rig: section.key=value; may be given again"),
        "KEY=VALUE");
}

void add_rig_options(CLI::App &command, rig_arguments &arguments)
{
    command.add_option("RIG", arguments.rig, "a shipped rig (see `berth rigs`) or the path of a rig file")
        ->required();
    command
        .add_option("--robot", arguments.robot,
                    "a robot preset (see `berth robots`) or the path of a preset file: the rig gets its period and "
                    "dead time, before --set; of a reported range, the upper end")
        ->type_name("NAME")
        ->check(is_named("a robot preset needs a name; see `berth robots`"));
    add_set_option(command, arguments.overrides);
    one_value(command.add_option("--with", arguments.with,
                                 "compensation of the dead time, before --set: " + compensation_names() +
                                     "; may be given again"),
              "NAME");
    command.add_flag("--json", arguments.json, "print one JSON object and nothing else");
}

void add_amplitude_option(CLI::App &command, rig_arguments &arguments)
{
    command
        .add_option("--amplitude", arguments.amplitude_m,
                    "of the manipulator's motion, at which effects that depend on it are taken, such as backlash; "
                    "default: that of the profile, or 0.01 m; 0: small motions, without them")
        ->check(CLI::Validator(CLI::Number).description(""))
        ->type_name("M");
}

void add_check_options(CLI::App &command, rig_arguments &arguments)
{
    CLI::Option *const check =
        command.add_flag("--check", arguments.check, "for scripts: exit code 1 unless the loop is stable");
    command
        .add_option("--margin-ms", arguments.check_margin_ms,
                    "with --check: and unless the robot's dead time may be so much longer")
        ->check(is_within(0.0, 1e5))
        ->needs(check)
        ->type_name("MS");
}

void add_jitter_option(CLI::App &command, std::string &jitter_file)
{
    command
        .add_option("--jitter", jitter_file,
                    "how late the loop wakes: a histogram of cyclictest --json (run.lateness_file)")
        ->check(is_named("a file needs a name"))
        ->type_name("FILE");
}

void add_run_folder_options(CLI::App &command, run_arguments &arguments)
{
    CLI::Option *const out =
        command
            .add_option("--out", arguments.out_folder,
                        "folder for the log, which is DIR/RIG.ulg; default: build/runs/RIG/TIME, a "
                        "folder of its own for each run, and a page of all runs")
            ->type_name("DIR");
    command.add_option("--keep", arguments.keep, "without --out: keep the newest N runs of the rig; default: all")
        ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000}).description(""))
        ->type_name("N")
        ->excludes(out);
}

void add_init_options(CLI::App &command, init_arguments &arguments)
{
    command.add_option("FILE", arguments.file, "the rig file to write, NAME.toml")->required();
    command
        .add_option(
            "--robot", arguments.robot,
            "a robot preset (see `berth robots`) or the path of a preset file; default: the robot of the rig ess")
        ->type_name("NAME");
    command.add_option("--sensor", arguments.sensor, "the force sensor")
        ->check(CLI::IsMember(template_sensors()))
        ->capture_default_str();
    command.add_option("--object", arguments.object, "what the robot meets")
        ->check(CLI::IsMember(template_objects()))
        ->capture_default_str();
    command.add_flag("--force", arguments.force, "overwrite a file of this name");
}

void add_compare_options(CLI::App &command, compare_arguments &arguments)
{
    command.add_option("A", arguments.a, log_meaning)->required();
    command.add_option("B", arguments.b, log_meaning)->required();
    command.add_option("--page", arguments.page, "write a page with the curves of both over each other")
        ->type_name("FILE.html");
    command.add_flag("--json", arguments.json, "print one JSON object and nothing else");
}

void add_report_options(CLI::App &command, report_arguments &arguments)
{
    command.add_option("LOG", arguments.log, log_meaning)->required();
    command
        .add_option("--accuracy", arguments.accuracy_file,
                    "what `berth accuracy RIG --json` printed, of a run with an arm")
        ->type_name("JSON");
    command.add_flag("--no-poses", arguments.no_poses,
                     "of a run with an arm: leave out its swing pose by pose, which may take a minute");
    command
        .add_option("--out", arguments.page,
                    "the page to write, and a picture beside it; default: LOG.html beside the log")
        ->type_name("FILE.html")
        ->check(is_named("a page needs a name"));
}

void add_varying_options(CLI::App &command, varying_arguments &arguments, const char *ticks)
{
    add_rig_options(command, arguments);
    add_jitter_option(command, arguments.jitter_file);
    command.add_option("--seed", arguments.seed, "of jitter and losses (run.seed)")
        ->check(CLI::Range(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()).description(""))
        ->type_name("INTEGER");
    command.add_option("--ticks", arguments.ticks, ticks)->check(CLI::Range(1000, 2000000));
    add_amplitude_option(command, arguments);
}

void add_map_options(CLI::App &command, map_arguments &arguments)
{
    add_varying_options(command, arguments,
                        "length of the sequence that the growth with jitter, drift or losses is taken from, default "
                        "8000, or 20 s; or of the runs in the time domain, default 20 s");
    command.add_option(
        "--vary", arguments.vary,
        "elasticity or mass of the object: axes are frequency ratio and damping of the coupled system");
    command.add_option("--x", arguments.x, "any number of the rig along x")->type_name("KEY=FROM:TO:COUNT");
    command.add_option("--y", arguments.y, "another along y")->type_name("KEY=FROM:TO:COUNT");
    command.add_option("--grid", arguments.grid, "points along x and y, with --vary")
        ->type_name("NXxNY")
        ->capture_default_str();
    command
        .add_option("--x-range", arguments.x_range,
                    "with --vary: omega/omega_M; default: from below what the object allows to beyond the robot's "
                    "5 Hz wall, or with mass to beyond an object without mass")
        ->type_name("FROM:TO");
    command.add_option("--y-range", arguments.y_range, "with --vary: damping ratio; default 0:0.3")
        ->type_name("FROM:TO");
    command.add_option("--out", arguments.out_folder, "folder for the CSV file")
        ->type_name("DIR")
        ->capture_default_str();
    command.add_flag("--time-domain", arguments.time_domain,
                     "run each point and measure how its swing grows; always so with passivity, tank, "
                     "identification and adaptive inverse, which have no eigenvalues");
    command
        .add_option(
            "--model", arguments.model,
            "which parameters prediction and the like get: each point as it is (point), the rig as it is wherever "
            "the point is (rig), or each point wrong by the rig's tolerances, the worst of all (tolerances)")
        ->check(CLI::IsMember({"point", "rig", "tolerances"}).description(""))
        ->type_name("WHAT");
    command.add_option("--threads", arguments.threads, "default: one for each core")->check(CLI::Range(1, 1024));
    command.add_flag("--picture", arguments.picture, "draw the map beside its CSV file");
    command.add_flag("--yes", arguments.yes, "go on where a map is very large");
}

void add_arm_options(CLI::App &command, arm_arguments &arguments)
{
    command
        .add_option("ARM", arguments.arm,
                    "a shipped arm, the path of an arm file, or of a URDF file (.urdf, .xacro)")
        ->required();
    command
        .add_option("--base", arguments.base,
                    "URDF: the link that is the satellite; default: the root, or the link behind a floating joint")
        ->type_name("LINK");
    command
        .add_option("--tool", arguments.tool,
                    "URDF: the link at the arm's end; default: the end of the longest movable chain")
        ->type_name("LINK");
    one_value(command.add_option("--hold", arguments.holds,
                                 "URDF: a joint that does not move, at a value in rad or m; may be given again. "
                                 "Joints beside the arm are held at 0 or, where their range excludes it, in its "
                                 "middle"),
              "JOINT[=VALUE]");
    command.add_flag("--planar", arguments.is_planar, "URDF: joints about z, motion in x and y");
    command
        .add_option("--states", arguments.states_file,
                    "a JSON list of states: print inertia, bias forces, accelerations and momentum at each as JSON")
        ->type_name("FILE");
}

void add_accuracy_options(CLI::App &command, accuracy_arguments &arguments)
{
    command.add_option("RIG", arguments.arm, "a rig with an arm, or an arm; shipped or the path of a file")
        ->required();
    add_set_option(command, arguments.overrides);
    command
        .add_option("--step-ms", arguments.step_ms,
                    "of the loop that the verdict is about (default: the rig's, 2.5 for an arm)")
        ->type_name("MS");
    command.add_option("--repeatability-um", arguments.repeatability_um, "of the robot, to compare with")
        ->check(is_within(1e-3, 1e6))
        ->type_name("UM")
        ->capture_default_str();
    command.add_flag("--json", arguments.json, "print one JSON object and nothing else");
}

void add_reduce_options(CLI::App &command, reduce_arguments &arguments)
{
    add_rig_options(command, arguments);
    command
        .add_option("--arm", arguments.arm,
                    "a shipped arm or the path of an arm file; default: the rig's own, or ess")
        ->type_name("ARM");
    command.add_option("--pose", arguments.pose, "of the joints, rad; default: where the arm starts")
        ->type_name("Q1,Q2,...");
    command
        .add_option("--direction", arguments.direction,
                    "of the object's deflection, in the world; default: manipulator.direction_* of the rig")
        ->type_name("X,Y[,Z]");
    command.add_option("--sweep", arguments.sweep, "one joint from pose to pose, rad")
        ->type_name("JOINT=FROM:TO:COUNT");
    command
        .add_option(
            "--amplitude", arguments.amplitudes,
            "let the whole arm go, with the object and not linearised, from deflections of the tool of these "
            "sizes, m, by equal ratios: where its swing parts company with the reduction's")
        ->type_name("FROM:TO:COUNT")
        ->check([](const std::string &text) {
            return text.empty() ? std::string("must be FROM:TO:COUNT, and is empty") : std::string();
        });
    command.add_flag("--held", arguments.is_held, "hold the satellite");
    command.add_flag("--guided", arguments.is_guided,
                     "let the tool move along the direction alone, as on a rail; no run has one, and so the loop is "
                     "another than that of `berth run` and `berth eigen`");
}

void add_tolerance_options(CLI::App &command, compensate_arguments &arguments)
{
    const auto share = [&](const char *name, double &percent, const char *meaning) {
        command.add_option(name, percent, meaning)
            ->check(is_within(0.0, 99.0))
            ->type_name("PERCENT")
            ->capture_default_str();
    };
    share("--dead-time", arguments.dead_time_percent, "by which the robot's dead time may be off, either way");
    share("--stiffness", arguments.stiffness_percent, "the same of the object's stiffness");
    share("--mass", arguments.mass_percent, "the same of its mass");
    command
        .add_option("--noise", arguments.noise_N,
                    "of the force: standard deviation; default: ten times the rig's, or 2 N if that is less")
        ->check(is_within(0.0, 1e4))
        ->type_name("N");
    command
        .add_option("--margin-ms", arguments.margin_ms,
                    "the least dissipation is that with which the loop stays stable where the dead time is so much "
                    "longer")
        ->check(is_within(0.0, 1e4))
        ->type_name("MS")
        ->capture_default_str();
    command.add_option("--margin-dB", arguments.margin_dB, "and the force so much larger")
        ->check(is_within(0.0, 40.0))
        ->type_name("DB")
        ->capture_default_str();
    command.add_option("--duration", arguments.duration_s, "of each trial, from the release on")
        ->check(is_within(0.1, 600.0))
        ->type_name("S")
        ->capture_default_str();
}

void add_diagnose_options(CLI::App &command, diagnose_arguments &arguments)
{
    command
        .add_option("RECORD", arguments.records,
                    "a log of `berth run` (.ulg) or a CSV file (also .gz) with units in its header")
        ->required();
    command.add_option("--rig", arguments.rig, "the rig as you assume it to be: a shipped one or a rig file")
        ->required();
    add_set_option(command, arguments.overrides);
    command
        .add_option("--validate", arguments.validation, "a record with another command, on which the gain is proved")
        ->type_name("FILE");
    command
        .add_option("--repeat", arguments.repetition,
                    "the operator's command once more: how much of a record is noise")
        ->type_name("FILE");
    command.add_option("--standstill", arguments.standstill, "a record in which nothing moves: noise alone")
        ->type_name("FILE");
    one_value(command.add_option("--without", arguments.without, "leave out an effect; may be given again"),
              "EFFECT");
    command
        .add_option("--time-limit", arguments.limit_s,
                    "processor time after which nothing more is tried; without it as long as the record, "
                    "a minute at least")
        ->check(is_within(0.0, 1e6))
        ->type_name("S");
    command
        .add_option("--out", arguments.out_folder,
                    "folder for diagnosis.json, the rigs given.toml and extended.toml, series.csv and, "
                    "if one is proposed, next_experiment.csv")
        ->type_name("DIR")
        ->capture_default_str();
    command.add_flag("--json", arguments.json, "print one JSON object and nothing else");
}

void add_rths_options(CLI::App &command, rths_arguments &arguments)
{
    command
        .add_option(
            "DATA_DIR", arguments.data_folder,
            "folder with case_1.txt to case_4.txt (mass, damping, stiffness) and el_centro.csv.gz, kobe.csv.gz, "
            "morgan.csv.gz (t_s, ground_acceleration_m_per_s2)")
        ->required();
    command.add_option("--earthquake", arguments.earthquake, "times 0.4")
        ->check(CLI::IsMember({"el_centro", "kobe", "morgan"}))
        ->capture_default_str();
    command.add_option("--case", arguments.building_case, "of the frame")
        ->check(CLI::Range(1, 4))
        ->capture_default_str();
    command.add_option("--controller", arguments.controller, "what moves the actuator")
        ->check(CLI::IsMember(rths::controller_names()))
        ->capture_default_str();
    command
        .add_option("--perturbed", arguments.perturbed,
                    "how many plants with drawn parameters to run besides the nominal one, and tell the worst of")
        ->check(CLI::Range(0, 10000));
    command.add_option("--seed", arguments.seed, "of the sensors' noise and the perturbed plants")
        ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 53).description(""))
        ->type_name("INTEGER")
        ->capture_default_str();
    command.add_option("--noise", arguments.noise, "times the benchmark's; 0: none, and ideal converters")
        ->check(is_within(0.0, 1000.0))
        ->capture_default_str();
    command
        .add_option("--force-age", arguments.force_age_samples,
                    "age of the force in samples that the firmware's force lead assumes; 1 is right")
        ->check(is_within(0.0, 1.0))
        ->capture_default_str();
    command
        .add_option("--samples", arguments.samples_file, "write every sample of the nominal run to this CSV file")
        ->check(is_named("a file needs a name"))
        ->type_name("FILE");
    command.add_flag("--json", arguments.json, "print one JSON object and nothing else");
}

} // namespace berth
