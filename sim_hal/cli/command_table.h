/* What the program's commands and options are, as plain structures: completion and man pages are made from them. */
#ifndef SIM_HAL_CLI_COMMAND_TABLE_H
#define SIM_HAL_CLI_COMMAND_TABLE_H

#include <string>
#include <vector>

namespace CLI
{
class App;
}

namespace berth
{

struct option_entry {
    std::string name;  /* "--json", or "RIG" of a positional one */
    std::string value; /* what it takes, as "NAME"; empty: a flag */
    std::string meaning;
    std::string standard;            /* its value where nobody gives one; empty: none is stated */
    std::vector<std::string> words;  /* permitted or known values; "KEY=" where a value is put behind */
    std::vector<std::string> values; /* then all of "KEY=VALUE" that are known */
    bool is_needed = false;
    bool takes_files = false; /* also, or only */

    bool is_positional() const { return name[0] != '-'; }
};

struct command_entry {
    std::string name;
    std::string meaning;
    std::vector<option_entry> options;
};

/* In the order of the program's help. */
std::vector<command_entry> command_table(const CLI::App &app);

std::vector<std::string> names_of(const std::vector<command_entry> &table);

} // namespace berth

#endif
