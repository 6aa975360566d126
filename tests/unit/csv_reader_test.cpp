/* CSV files as programs write them: what is read from them, and what is refused with which words. Records and
 * profiles are read alike. */
#include <cmath>
#include <doctest/doctest.h>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/diagnosis/record/record_table.h"
#include "../../sim_hal/hil/column_units.h"
#include "../../sim_hal/hil/csv_cells.h"
#include "../../sim_hal/hil/profile.h"
#include "../support/files.h"

namespace berth
{

namespace
{

const file_column any_position{"", "m", 1.0, "profile.column", "profile.scale"};

std::string in_utf16(const std::string &text, bool is_little, bool has_mark)
{
    std::string wide = !has_mark ? "" : is_little ? "\xff\xfe" : "\xfe\xff";
    for (const char c : text) {
        wide += is_little ? std::string{c, '\0'} : std::string{'\0', c};
    }
    return wide;
}

std::string with_ends(std::string text, const std::string &end)
{
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += end.size()) {
        text.replace(at, 1, end);
    }
    return text;
}

struct form {
    const char *name;
    std::string text;
};

/* All of them hold 0, 0.5, 1 s and 0, 0.25, -1.5e-3 m. */
const std::string plain = "t_s,x_m\n0,0\n0.5,0.25\n1,-1.5e-3\n";
const form forms[] = {
    {"as berth writes it", plain},
    {"no line end at the end", "t_s,x_m\n0,0\n0.5,0.25\n1,-1.5e-3"},
    {"CR LF", with_ends(plain, "\r\n")},
    {"CR", with_ends(plain, "\r")},
    {"byte order mark", "\xef\xbb\xbf" + plain},
    {"UTF-16, little, mark", in_utf16(plain, true, true)},
    {"UTF-16, big, mark", in_utf16(plain, false, true)},
    {"UTF-16, little, no mark", in_utf16(plain, true, false)},
    {"UTF-16, big, no mark", in_utf16(plain, false, false)},
    {"semicolons", "t_s;x_m\n0;0\n0.5;0.25\n1;-1.5e-3\n"},
    {"semicolons, decimal commas", "t_s;x_m\n0;0\n0,5;0,25\n1;-1,5e-3\n"},
    {"tabs", "t_s\tx_m\n0\t0\n0.5\t0.25\n1\t-1.5e-3\n"},
    {"tabs, decimal commas", "t_s\tx_m\n0\t0\n0,5\t0,25\n1,0\t-1,5e-3\n"},
    {"commas, decimal commas in quotes", "t_s,x_m\n\"0\",\"0\"\n\"0,5\",\"0,25\"\n\"1\",\"-1,5e-3\"\n"},
    {"quoted names", "\"t_s\",\"x_m\"\n0,0\n0.5,0.25\n1,-1.5e-3\n"},
    {"quoted everything", "\"t_s\",\"x_m\"\n\"0\",\"0\"\n\"0.5\",\"0.25\"\n\"1\",\"-1.5e-3\"\n"},
    {"blanks about cells", " t_s , \"x_m\" \n 0, 0\n 0.5 , 0.25\n1,\t-1.5e-3 \n"},
    {"plus signs", "t_s,x_m\n+0,+0\n+0.5,+0.25\n+1,-1.5e-3\n"},
    {"exponents of Fortran", "t_s,x_m\n0.0D+00,0D0\n5.0D-01,2.5d-1\n1,-1.5D-03\n"},
    {"comment above", "# slow move\n% of the left robot\nt_s,x_m\n0,0\n0.5,0.25\n1,-1.5e-3\n"},
    {"comments and empty lines between",
     "\nt_s,x_m\n\n0,0\n# a break, at noon\n0.5,0.25\n  % and on\n\n1,-1.5e-3\n\n"},
    {"rows of nothing at the end", "t_s,x_m\n0,0\n0.5,0.25\n1,-1.5e-3\n,\n,\n"},
    {"preamble", "Device: XY-7\nStart, 2026-03-04\nRate,1000\nTime,10:12:13\n\nt_s,x_m\n0,0\n0.5,0.25\n1,-1.5e-3\n"},
    {"preamble with other delimiters", "a,b,c,d,e\nsep=;\nt_s;x_m\n0;0\n0,5;0,25\n1;-0,0015\n"},
    {"a row of units", "t_s,x_m\ns,m\n0,0\n0.5,0.25\n1,-1.5e-3\n"},
    {"a row of units in brackets", "t_s;x_m\n[s];[m]\n0;0\n0.5;0.25\n1;-1.5e-3\n"},
    {"a row of units below a preamble", "# made today\nchannel list\nt_s,x_m\n(s),(m)\n0,0\n0.5,0.25\n1,-1.5e-3\n"},
    {"units in brackets in the names", "t [s],x [m]\n0,0\n0.5,0.25\n1,-1.5e-3\n"},
    {"a last comma in each line", "t_s,x_m,\n0,0,\n0.5,0.25,\n1,-1.5e-3,\n"},
    {"a last comma in each row", "t_s,x_m\n0,0,\n0.5,0.25,\n1,-1.5e-3,\n"},
};

/* With a first column that nobody needs. */
const form wider_forms[] = {
    {"a comma in a quoted name", "\"Temperature, motor\",t_s,x_m\n31,0,0\n31,0.5,0.25\n31,1,-1.5e-3\n"},
    {"quotes in a quoted name", "\"the \"\"old\"\" one, left\",t_s,x_m\n31,0,0\n31,0.5,0.25\n31,1,-1.5e-3\n"},
    {"a line end in a quoted name", "\"Temperature\n(motor)\",t_s,x_m\n31,0,0\n31,0.5,0.25\n31,1,-1.5e-3\n"},
    {"commas, quotes and line ends in quoted cells",
     "said,t_s,x_m\n\"up, and on\",0,0\n\"the \"\"end\"\"\",0.5,0.25\n\"a\nb\",1,-1.5e-3\n"},
    {"a quote within a cell", "pipe,t_s,x_m\n5\" left,0,0\n5\" left,0.5,0.25\n5\" left,1,-1.5e-3\n"},
    {"units that are not known", "mood,t_s,x_m\nsmiles,s,m\n1,0,0\n1,0.5,0.25\n1,1,-1.5e-3\n"},
    {"no unit for some", "count,t_s,x_m\n,s,m\n1,0,0\n1,0.5,0.25\n1,1,-1.5e-3\n"},
};

void check_holds(const std::vector<double> &times_s, const std::vector<double> &values_m)
{
    const std::vector<double> wanted_s{0.0, 0.5, 1.0};
    const std::vector<double> wanted_m{0.0, 0.25, -1.5e-3};
    CHECK(times_s == wanted_s);
    CHECK(values_m == wanted_m);
}

void check_both_readers(const form &one, const std::string &column)
{
    INFO(one.name);
    const temporary_folder folder;
    const std::string path = folder / "x.csv";
    std::ofstream(path, std::ios::binary) << one.text;
    file_column wanted = any_position;
    wanted.name = column;
    const csv_columns profile = read_csv_columns(path, wanted);
    check_holds(profile.times_s, profile.values);
    const record_table record = read_record_table(path, "t_s", {"t_s", "x_m"});
    REQUIRE(record.find("t_s") != nullptr);
    REQUIRE(record.find("x_m") != nullptr);
    check_holds(record.find("t_s")->values, record.find("x_m")->values);
    CHECK(std::vector<int>(record.lines.begin(), record.lines.end()) == profile.lines);
}

std::string refusal(const std::string &text, const file_column &wanted = any_position)
{
    const temporary_folder folder;
    const std::string path = folder / "x.csv";
    std::ofstream(path, std::ios::binary) << text;
    try {
        read_csv_columns(path, wanted);
    } catch (const input_error &error) {
        return std::string(error.what()).substr(path.size());
    }
    return "";
}

} // namespace

TEST_CASE("csv: records and profiles are read alike, in every form")
{
    for (const form &one : forms) {
        check_both_readers(one, "");
    }
    for (const form &one : wider_forms) {
        check_both_readers(one, "x_m");
    }
}

TEST_CASE("csv: lines are counted as an editor does")
{
    const temporary_folder folder;
    std::ofstream(folder / "x.csv") << "# one\npreamble\nt_s,x_m,said\ns,m,\n0,0,\"a\nb\"\n\n1,1,c\n";
    file_column wanted = any_position;
    wanted.name = "x_m";
    CHECK(read_csv_columns(folder / "x.csv", wanted).lines == std::vector<int>{5, 8});
}

TEST_CASE("csv: a time may be a stamp or in another unit")
{
    const struct {
        const char *text;
        double step_s;
    } times[] = {
        {"t_s,x_m\n1772619072.25,0\n1772619072.75,1\n", 0.5},
        {"t_ms,x_m\n100,0\n600,1\n", 0.5},
        {"time_us,x_m\n1772619072250000,0\n1772619072750000,1\n", 0.5},
        {"Time [ms],x_m\n100,0\n600,1\n", 0.5},
        {"Zeit,t (ns),x_m\n7,0,0\n8,500000000,1\n", 0.5},
        {"time,x_m\nms,m\n100,0\n600,1\n", 0.5},
        {"time,x_m\n2026-03-04T10:11:12.25,0\n2026-03-04T10:11:12.75,1\n", 0.5},
        {"t_s,x_m\n2026-12-31 23:59:59.5Z,0\n2027-01-01 00:00:00Z,1\n", 0.5},
        {"t_s,x_m\n2024-02-28T23:59:59+01:00,0\n2024-03-01T00:00:00+01:00,1\n", 86401.0},
        {"timestamp;x_m\n10:11:12,25;0\n10:11:12,75;1\n", 0.5},
    };
    for (const auto &one : times) {
        INFO(one.text);
        const temporary_folder folder;
        std::ofstream(folder / "x.csv") << one.text;
        file_column wanted = any_position;
        wanted.name = "x_m";
        const csv_columns read = read_csv_columns(folder / "x.csv", wanted);
        REQUIRE(read.times_s.size() == 2);
        CHECK(std::abs(read.times_s[1] - read.times_s[0] - one.step_s) < 1e-6);
    }
    CHECK(cell_stamp_s("1970-01-02T00:00:01Z") == 86401.0);
    CHECK(cell_stamp_s("2026-03-04T10:11:12+01:00") == 1772615472.0);
    for (const char *none :
         {"2026-13-04T10:11:12", "2026-03-04", "10:61:00", "10:11", "2026", "", "Z", "x10:11:12"}) {
        CHECK(!cell_stamp_s(none));
    }
}

TEST_CASE("csv: a unit that is not the one wanted is refused with the scale that converts it")
{
    const struct {
        const char *text;
        const char *message;
    } refused[] = {
        {"t_s,x_mm\n0,0\n1,1\n", ":1: x_mm is in mm, and what is played in m; convert it: profile.scale=0.001"},
        {"t_s,x [cm]\n0,0\n1,1\n", ":1: x [cm] is in cm, and what is played in m; convert it: profile.scale=0.01"},
        {"t_s,X_MM\n0,0\n1,1\n", ":1: X_MM is in MM, and what is played in m; convert it: profile.scale=0.001"},
        {"t_s,x\ns,mm\n0,0\n1,1\n", ":2: x is in mm, and what is played in m; convert it: profile.scale=0.001"},
        {"t_s,x_m\ns,mm\n0,0\n1,1\n", ":2: x_m is in mm, and what is played in m; convert it: profile.scale=0.001"},
        {"t_s,x_in\n0,0\n1,1\n", "profile.scale=0.0254"},
        {"t_s,x (\xc2\xb5m)\n0,0\n1,1\n", "profile.scale=1e-06"},
        {"t_s,force_N\n0,0\n1,1\n", ":1: force_N is in N, and what is played in m, which is something else"},
        {"t_s,angle_deg\n0,0\n1,1\n", "is in deg"},
        {"t_s,speed_mm_per_s\n0,0\n1,1\n", "is in mm_per_s"},
        {"t_s,x [furlong]\n0,0\n1,1\n", "is in furlong"},
        {"time,x_m\n0,0\n1,1\n", ":2: the column time names no unit; call it t_s"},
        {"t_s,x_m\nms,m\n0,0\n1,1\n", ":2: t_s is in ms here"},
    };
    for (const auto &one : refused) {
        INFO(one.text);
        const std::string message = refusal(one.text);
        INFO(message);
        CHECK(message.find(one.message) != std::string::npos);
    }
    file_column scaled = any_position;
    scaled.scale = 1e-3;
    CHECK(refusal("t_s,x_mm\n0,0\n1,1\n", scaled).empty());
    scaled.scale = -1.0; /* turns it over, and converts nothing */
    CHECK(refusal("t_s,x_mm\n0,0\n1,1\n", scaled).find("profile.scale=0.001") != std::string::npos);
}

TEST_CASE("csv: a column without a unit is told")
{
    const temporary_folder folder;
    std::ofstream(folder / "x.csv") << "t_s,x\n0,0\n1,1\n";
    CHECK(read_csv_columns(folder / "x.csv", any_position).note.find(":1: the column x names no unit") !=
          std::string::npos);
    std::ofstream(folder / "x.csv") << plain;
    CHECK(read_csv_columns(folder / "x.csv", any_position).note.empty());
}

TEST_CASE("csv: what is wrong with a file is told by line")
{
    const struct {
        const char *text;
        const char *message;
    } refused[] = {
        {"", ": is empty"},
        {"# t_s,x_m\n0,0\n1,1\n", ":2: has numbers and no names"},
        {"t_s x_m\n0 0\n1 1\n", ":1: its columns are separated by blanks"},
        {"t_s,x_m\n0,0\n1,1,5\n", ":3: has more cells than the 2"},
        {"t_s,x_m\n0,0\n1\n", ":3: has 1 cells, too few"},
        {"t_s,x_m\n0,0\n1,\n", ":3: x_m: the cell is empty"},
        {"t_s,x_m\n0,0\n1,nan\n", ":3: x_m: \"nan\" is not a finite number; leave out rows"},
        {"t_s,x_m\n0,0\n1,2026-03-04T10:11:12\n", "is a date or a clock time and no number"},
        {"t_s,x_m\n04/03/2026 10:11:12,0\n1,1\n", "write a date as 2026-03-04T10:11:12"},
        {"t_s;x_m\n0;0\n1;1.234,5\n", "without marks between the thousands"},
        {"t_s;x_m\n0;1,5\n1;2.5\n", ":3: \"2.5\" has a point where others have a comma"},
        {"t_s;x_m\n0;1.234\n1;2,5\n", ":3: \"2,5\" has a comma where others have a point"},
        {"t_s;x_m\n0;1,234\n1;2,500\n", "may stand before decimals or between thousands"},
        {"t_s,x_m\n0,\"0\n1,1\n", ":2: a quote (\") is opened and never closed"},
        {"t_s,x_m\n0,0\n1,\"1\n", ":3: a quote (\") is opened and never closed"},
        {"x_m,y_m\n0,0\n1,1\n", ":1: there is no column t_s; the columns are x_m, y_m"},
        {"device 7\n\nx_m,y_m\nm,m\n0,0\n1,1\n", ":3: there is no column t_s; the columns are x_m, y_m"},
        {"t_s,x_m,y_m\n0,0,0\n1,1,1\n", ":1: has 2 columns beside the time (t_s, x_m, y_m); name one"},
    };
    for (const auto &one : refused) {
        INFO(one.text);
        const std::string message = refusal(one.text);
        INFO(message);
        CHECK(message.find(one.message) != std::string::npos);
    }
}

TEST_CASE("csv: units by their names")
{
    const struct {
        const char *name;
        const char *bare;
        const char *unit;
    } names[] = {{"force_kN", "force", "kN"},      {"force [kN]", "force", "kN"},
                 {"force(kN)", "force", "kN"},     {"v_mm_per_s", "v", "mm_per_s"},
                 {"x_left", "x_left", ""},         {"x (left)", "x (left)", ""},
                 {"x [left]", "x", "left"},        {"axis_A_mm", "axis_A", "mm"},
                 {"x_position", "x_position", ""}, {"operator_velocity_m_per_s", "operator_velocity", "m_per_s"}};
    for (const auto &one : names) {
        INFO(one.name);
        CHECK(split_column_name(one.name).bare == one.bare);
        CHECK(split_column_name(one.name).unit == one.unit);
    }
    CHECK(find_unit("mN")->factor == 1e-3);
    CHECK(find_unit("MN")->factor == 1e6);
    CHECK(find_unit("mn") == nullptr); /* one or the other */
    CHECK(find_unit("KN")->factor == 1e3);
    CHECK(find_unit("lbf")->factor == doctest::Approx(4.448222));
    for (const char *time : {"t_s", "Time [ms]", "timestamp", "t", "Date/Time", "time_us"}) {
        CHECK(is_name_of_time(time));
    }
    for (const char *none : {"t_m", "temperature", "time_left", "tick", ""}) {
        CHECK(!is_name_of_time(none));
    }
}

} // namespace berth
