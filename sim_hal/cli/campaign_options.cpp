#include "options.h"

namespace berth
{

void add_campaign_options(CLI::App &command, campaign_arguments &arguments)
{
    command
        .add_option("FILE", arguments.file,
                    "a campaign file: the base rig, what varies, which questions; or the word report")
        ->required();
    command.add_option("FOLDER", arguments.folder,
                       "with report: the folder of a campaign; default: the newest in build/campaigns");
    command
        .add_option("--out", arguments.out_folder,
                    "folder for the table samples.parquet; default: build/campaigns/NAME, as the file is called")
        ->type_name("DIR");
    CLI::Option *const resume = command.add_flag("--resume", arguments.resume, "go on where it stopped");
    command.add_flag("--anew", arguments.anew, "begin anew: the samples in the folder are deleted")
        ->excludes(resume);
    command.add_flag("--yes", arguments.yes,
                     "start it even if it takes more than a day, or the disk may be too small");
    command
        .add_option("--workers", arguments.workers, "processes on this machine, or in Slurm; default: one per core")
        ->check(CLI::Range(1, 100000))
        ->type_name("N");
    CLI::Option *const scheduler =
        command
            .add_option("--scheduler", arguments.scheduler,
                        "address of a Dask scheduler that is there, tcp://HOST:8786, with its workers")
            ->check(is_named("a scheduler needs an address, as tcp://HOST:8786"))
            ->type_name("ADDRESS");
    command
        .add_flag("--slurm", arguments.slurm,
                  "start the workers as jobs of Slurm, as the table [slurm] of the file says")
        ->excludes(scheduler);
}

} // namespace berth
