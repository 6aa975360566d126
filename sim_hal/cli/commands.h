/* The subcommands of `berth`. Each returns the exit code; wrong input comes as input_error. */
#ifndef SIM_HAL_CLI_COMMANDS_H
#define SIM_HAL_CLI_COMMANDS_H

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "../../hal/rig/rig_file.h"
#include "../arm/step_accuracy.h"

namespace CLI
{
class App;
}

namespace berth
{

/* What every subcommand that takes a rig has in common. */
struct rig_arguments {
    std::string rig;
    std::string robot;                  /* --robot; empty: the rig's own */
    std::vector<std::string> with;      /* compensation, by name */
    std::vector<std::string> overrides; /* --set */
    std::optional<double> amplitude_m;  /* --amplitude; nothing: the usual one */
    bool json = false;
    bool check = false;           /* --check: exit code 1 unless stable ... */
    double check_margin_ms = 0.0; /* ... with so much dead time to spare */
};

/* Of loops that change from tick to tick. */
struct varying_arguments : rig_arguments {
    std::string jitter_file; /* for run.lateness_file */
    std::int64_t seed = -1;  /* for run.seed; -1: that of the rig */
    std::int64_t ticks = 0;  /* 0: as many as it takes */
};

struct arm_arguments {
    std::string arm; /* a shipped arm, an arm file or a URDF file */
    std::string base;
    std::string tool;
    bool is_planar = false;
    std::vector<std::string> holds; /* JOINT=VALUE or JOINT */
    std::string states_file;
};

struct accuracy_arguments {
    std::string arm;
    std::vector<std::string> overrides; /* of a rig */
    std::optional<double>
        step_ms; /* else the rig's period, or that of the reference case for an arm without a rig */
    double repeatability_um = 1e6 * usual_repeatability_m;
    bool json = false;
};

struct reduce_arguments : rig_arguments {
    std::string arm;        /* empty: the rig's own, or "ess" */
    std::string pose;       /* rad, with commas; empty: where the arm starts */
    std::string direction;  /* in the world, with commas; empty: the rig's */
    std::string sweep;      /* JOINT=FROM:TO:COUNT */
    std::string amplitudes; /* FROM:TO:COUNT */
    bool is_held = false;
    bool is_guided = false;
};

struct compensate_arguments : rig_arguments {
    double dead_time_percent = 30.0; /* by which the rig may differ from its file, either way */
    double stiffness_percent = 50.0;
    double mass_percent = 20.0;
    std::optional<double> noise_N;
    double duration_s = 10.0;
    double margin_ms = 5.0; /* that a dissipator leaves */
    double margin_dB = 0.0;
    bool each = false; /* every method on every rig, instead of the worst */
};

struct limits_arguments : rig_arguments {
    double change_percent = 10.0; /* of what helps most */
};

struct run_arguments : rig_arguments {
    std::string jitter_file;
    std::string profile_file;
    std::string out_folder; /* empty: one of its own, see run_folder.h */
    std::int64_t keep = 0;  /* newest runs of the rig that stay; 0: all */
    bool no_log = false;
    bool no_advice = false;
    bool print_config = false;
};

struct map_arguments : varying_arguments {
    std::string vary; /* elasticity, mass, or nothing with x and y */
    std::string x;    /* key=from:to:count */
    std::string y;
    std::string grid = "200x200";
    std::string x_range; /* from:to, of the axes of `vary` */
    std::string y_range;
    std::string out_folder = "build/maps";
    bool time_domain = false; /* the growth of runs, also where there are eigenvalues */
    std::string model = "point";
    int threads = 0; /* 0: one per core */
    bool yes = false;
    bool picture = false; /* and draw it */
};

struct diagnose_arguments : rig_arguments { /* `rig` comes as --rig */
    std::vector<std::string> records;
    std::string validation;
    std::string repetition;
    std::string standstill;
    std::vector<std::string> without;
    std::optional<double> limit_s;
    std::string out_folder = "build/diagnosis";
};

struct init_arguments {
    std::string file;
    std::string robot;
    std::string sensor = "one-axis";
    std::string object = "gripped";
    bool force = false; /* overwrites a file */
};

struct commission_arguments : rig_arguments {
    std::string stage;                 /* to run; empty: say how far it has come */
    std::string waive;                 /* a stage; empty: none */
    std::string because;               /* of the waiver */
    std::vector<std::string> hardware; /* overrides that the simulated hardware alone has */
    std::vector<std::string> poses;    /* X,Y,Z */
    std::vector<std::string> logs;     /* of the target */
    std::string record;                /* empty: record.json in the folder */
    std::string out_folder;            /* empty: build/commissioning/RIG */
    double ramp_s = 60.0;
    double margin = 0.01;
};

struct compare_arguments {
    std::string a; /* a log, or the folder of a run */
    std::string b;
    std::string page; /* with the curves over each other; empty: none */
    bool json = false;
};

struct report_arguments {
    std::string log;
    std::string accuracy_file;
    bool no_poses = false; /* of an arm */
    std::string page;      /* empty: beside the log */
};

struct rths_arguments {
    std::string data_folder;
    std::string earthquake = "el_centro";
    int building_case = 1;
    std::string controller = "pi";
    int perturbed = 0;              /* how many plants besides the nominal one */
    std::int64_t seed = 1;          /* of noise and plants */
    double noise = 1.0;             /* 0: none, and ideal converters */
    double force_age_samples = 1.0; /* as the force lead is told */
    std::string samples_file;
    bool json = false;
};

struct campaign_arguments {
    std::string file;   /* or the word "report" */
    std::string folder; /* of a report; empty: the newest campaign */
    std::string out_folder;
    std::string scheduler; /* address; empty: workers of its own */
    int workers = 0;       /* 0: one per core */
    bool slurm = false;
    bool resume = false;
    bool anew = false;
    bool yes = false;
};

struct live_arguments {
    std::string what;   /* a rig, a log or the folder of a run; or else `source` */
    std::string source; /* --from */
    std::string rig;    /* with `source` */
    std::string robot;
    std::vector<std::string> overrides;
    double speed = 1.0;
    std::string bind = "127.0.0.1";
    int port = 8765; /* where Foxglove looks first */
    std::string plotjuggler;
    std::string out_folder;
    bool end = false;
};

/* One line on standard output. A path that is no UTF-8 is shown with replacement characters. */
void print_json(const nlohmann::json &object);

/* Which effects of the rig are not in its eigenvalues, exponents and maps, and why: small motions, or an amplitude
 * greater than 0. On stderr, or as lines. */
std::vector<std::string> left_out(const rig &rig, double amplitude_m);
void tell_left_out(const rig &rig, double amplitude_m);

struct export_arguments {
    std::string log;
    bool csv = false;
    bool parquet = false;
    bool mcap = false;
};

int run_command(const run_arguments &arguments);
int replay_command(const std::string &log, bool json);
int summary_command(const std::string &log, bool json);
int candump_command(const std::string &log, bool json);
int export_command(const export_arguments &arguments);
int deadtime_command(const rig_arguments &arguments);
int eigen_command(const varying_arguments &arguments);
int map_command(const map_arguments &arguments);
int arm_command(const arm_arguments &arguments);
int accuracy_command(const accuracy_arguments &arguments);
int reduce_command(const reduce_arguments &arguments);
int compensate_command(const compensate_arguments &arguments);
int limits_command(const limits_arguments &arguments);
int rigs_command(bool json);
int schema_command();
int completion_command(const CLI::App &app, const std::string &shell);
int man_command(const CLI::App &app, const std::string &name);
int init_command(const init_arguments &arguments);
int check_command(const rig_arguments &arguments);
int commission_command(const commission_arguments &arguments);
int compare_command(const compare_arguments &arguments);
int report_command(const report_arguments &arguments);
int diagnose_command(const diagnose_arguments &arguments);
int effects_command(bool json);
int rths_command(const rths_arguments &arguments);
int campaign_command(const campaign_arguments &arguments);
int live_command(const live_arguments &arguments);
int robots_command(const std::string &name_or_path, bool json);

} // namespace berth

#endif
