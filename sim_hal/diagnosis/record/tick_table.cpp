#include "tick_table.h"

#include <algorithm>

#include "record_columns.h"

namespace berth
{

bool is_table_of_ticks(const record_table &table, const rig &rig)
{
    const bool has_ticks = std::all_of(tick_columns.begin(), tick_columns.end(),
                                       [&](const char *name) { return table.find(name) != nullptr; });
    return has_ticks &&
           std::all_of(std::begin(signal_members), std::end(signal_members), [&](const signal_member &signal) {
               const signal_source source = source_of(rig, signal.name);
               const bool is_own = source.column == signal.name && source.scale == 1.0 && source.offset == 0.0;
               return signal.name == "t_s" || (is_own && table.find(source.column) != nullptr);
           });
}

record record_of_table(const record_table &table, const std::string &path, const rig &rig, bool may_be_still)
{
    const auto column = [&](const char *name) -> const std::vector<double> & { return table.find(name)->values; };
    record_of_ticks rows(rig);
    rows.made.path = path;
    rows.made.hash = table.hash;
    rows.made.header_line = table.header_line;
    rows.made.is_from_this_firmware = false; /* the file does not say which one it was */
    for (std::size_t n = 0; n < table.lines.size(); n++) {
        tick_record tick{};
        tick.scheduled_ns = static_cast<std::int64_t>(column("scheduled_ns")[n]);
        tick.state = static_cast<std::uint8_t>(column("state")[n]);
        tick.limits = static_cast<std::uint8_t>(column("limits")[n]);
        tick.operator_position_m = column("operator_position_m")[n];
        tick.operator_velocity_m_per_s = column("operator_velocity_m_per_s")[n];
        tick.operator_force_N = column("operator_force_N")[n];
        tick.command_position_m = column("command_position_m")[n];
        tick.robot_position_m = column("robot_position_m")[n];
        tick.force_N = column("force_N")[n];
        rows.add(tick);
    }
    record made = rows.finish(rig, may_be_still);
    made.notes.push_back(
        "its columns are those of a log's ticks, and it is read as the log is: the rows in which the "
        "loop ran, robot_position_m as the next tick reports it");
    return made;
}

} // namespace berth
