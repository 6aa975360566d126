/* The unit that a column of a text file is in: as its name says, or the row below the names. */
#ifndef SIM_HAL_HIL_COLUMN_UNITS_H
#define SIM_HAL_HIL_COLUMN_UNITS_H

#include <optional>
#include <string>
#include <string_view>

namespace berth
{

/* `factor` times a value in this unit is the value in the unit `si`. */
struct column_unit {
    std::string_view name;
    std::string_view si; /* as names of columns end in it: m, N, s, m_per_s */
    double factor;
};

/* nullptr: not known. Brackets about it are left out. Letters count as they are; where no unit is written so, small
 * and large ones are the same, if that leaves one unit of length, force, time or velocity. */
const column_unit *find_unit(std::string_view text);

/* force_kN, "force [kN]", "force (kN)": "force" and "kN". */
struct column_name {
    std::string_view bare;
    std::string_view unit; /* empty: the name has none. After _ known ones only, in square brackets any text */
};
column_name split_column_name(std::string_view name);

/* "force [N]" as it would be called here: force_N. Other names stay as they are. */
std::string plain_column_name(std::string_view name);

/* t, time, stamp, timestamp, date, datetime, with or without a unit of time. */
bool is_name_of_time(std::string_view name);

/* The unit of a column by its name or by the row below the names, where it is not `si`. Empty: neither names a unit,
 * or it is `si`. `row_unit` may be empty. */
struct other_unit {
    std::string text;
    std::optional<double> factor; /* to `si`; nothing: of another quantity, or not known */
    bool is_of_row;
};
std::optional<other_unit> unit_other_than(std::string_view si, std::string_view name, std::string_view row_unit);

/* A rotary test bench in a file that speaks of a straight motion: rad beside m, Nm beside N, rad/s beside m/s, where
 * one counts as one. */
bool is_rotary_counterpart(std::string_view si, std::string_view unit);

} // namespace berth

#endif
