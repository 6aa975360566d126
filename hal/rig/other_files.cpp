#include "other_files.h"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "keys.h"
#include "rig_file.h"
#include "toml_file.h"

namespace berth
{

namespace
{

bool begins_with(const std::string &text, std::string_view start)
{
    return text.compare(0, start.size(), start) == 0;
}

bool is_utf16(const std::string &bytes)
{
    return begins_with(bytes, "\xff\xfe") || begins_with(bytes, "\xfe\xff");
}

/* A header of a table: names with commas, semicolons or tabs between, and nothing of TOML. */
bool is_table_of_values(const std::string &text)
{
    const std::string first = text.substr(0, text.find('\n'));
    return first.find_first_of(",;\t") != std::string::npos && first.find_first_of("=[]{}#") == std::string::npos &&
           first.find_first_not_of(" \t") == 0 && first.front() != ';';
}

/* A line that begins a section of a rig file. */
bool has_section(const std::string &text)
{
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t from = line.find_first_not_of(" \t[");
        const std::size_t end = line.find_first_of(".] \t\r", from);
        const bool is_header = from != std::string::npos && line.find('[') < from;
        if (is_header && nearest_section(line.substr(from, end - from)) == line.substr(from, end - from)) {
            return true;
        }
    }
    return false;
}

/* What cannot be read and has no section of one may be any other file. */
toml::table parse_rig_text(const std::string &text, const std::string &path)
try {
    return parse_toml(text, path);
} catch (const input_error &error) {
    if (has_section(text)) {
        throw;
    }
    throw input_error(error.what() +
                      std::string("; no line begins a section, as [loop]: is it a rig file? `berth run ess "
                                  "--print-config` shows one"));
}

} // namespace

void refuse_other_file(const std::string &path, const std::string &bytes)
{
    const auto refuse = [&](const std::string &what) { throw input_error(path + ": " + what); };
    const auto refuse_line_1 = [&](const std::string &what) { throw input_error(path + ":1: " + what); };
    if (begins_with(bytes, "ULog")) {
        refuse(
            "is a log, and no rig file; `berth summary LOG` tells what the run was, `berth diagnose LOG --rig RIG` "
            "compares it with a rig");
    }
    if (begins_with(bytes, "\x1f\x8b") || is_table_of_values(bytes)) {
        refuse_line_1(
            "is a table of values, as records are, and no rig file; `berth diagnose RECORD --rig RIG` reads it, or "
            "`berth run RIG --profile FILE`");
    }
    constexpr std::size_t looked_at = 1000;
    if (!is_utf16(bytes) && bytes.substr(0, looked_at).find('\0') != std::string::npos) {
        refuse_line_1("is no text, and no rig file: a rig file is TOML, see `berth run ess --print-config`");
    }
    if (const std::int64_t line = line_of_xml(bytes); line > 0) {
        throw input_error(
            path + ":" + std::to_string(line) +
            ": is XML, as URDF is, and no rig file; make an arm of it with `berth arm ROBOT.urdf --tool "
            "LINK > ARM.toml`, and put that into a rig: --set manipulator.arm=ARM.toml");
    }
    const toml::table table = parse_rig_text(bytes, path);
    if (table.empty()) {
        refuse("is empty: it states nothing; `berth run ess --print-config` shows a rig file");
    }
    if (table.contains("kind")) {
        refuse("is an arm file, and no rig file; put it into a rig: --set manipulator.arm=" + path);
    }
    if (table.contains("source")) {
        refuse("is a robot preset, and no rig file; give it beside a rig: --robot " + path);
    }
}

} // namespace berth
