#include "man_page.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "../../hal/version.h"

namespace berth
{

namespace
{

constexpr const char *exit_status =
    ".SH EXIT STATUS\n"
    ".TP\n0\nThe command did what it says.\n"
    ".TP\n1\nThe answer is no: a replay differs, a loop is not stable with\n"
    ".B \\-\\-check\n"
    "or\n"
    ".BR \"berth check\" .\n"
    ".TP\n2\nThe command line or a file is wrong; a line on standard error says how.\n"
    ".TP\n3\nThe robot of the rig does not answer.\n"
    ".TP\n128 + N\nSignal N ended the run.\n";

/* Text of roff: no escapes and no requests of its own. */
std::string escaped(const std::string &text)
{
    std::string result;
    for (const char c : text) {
        if (c == '\\') {
            result += "\\e";
        } else if (c == '-') {
            result += "\\-";
        } else {
            result += c;
        }
    }
    return !result.empty() && (result[0] == '.' || result[0] == '\'') ? "\\&" + result : result;
}

std::string capitals(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

void write_head(std::ostream &page, const std::string &name, const std::string &meaning)
{
    page << ".TH " << capitals(escaped(name)) << " 1 \"\" \"berth " << release
         << "\" \"berth\"\n.nh\n.ad l\n.SH NAME\n"
         << escaped(name) << " \\- " << escaped(meaning) << "\n.SH SYNOPSIS\n";
}

void write_option(std::ostream &page, const option_entry &option)
{
    page << ".TP\n\\fB" << escaped(option.name) << "\\fR";
    if (!option.is_positional() && !option.value.empty()) {
        page << " \\fI" << escaped(option.value) << "\\fR";
    }
    page << "\n" << escaped(option.meaning.empty() ? "no description" : option.meaning) << "\n";
    constexpr std::size_t few = 20; /* more stand in the list that `berth rigs` and the like print */
    if (!option.words.empty() && option.words.size() <= few) {
        page << ".br\nKnown:";
        for (const std::string &word : option.words) {
            page << (&word == &option.words.front() ? " " : ", ") << escaped(word);
        }
        page << ".\n";
    }
    if (!option.standard.empty()) {
        page << ".br\nDefault: " << escaped(option.standard) << ".\n";
    }
}

} // namespace

std::string man_page(const std::vector<command_entry> &table)
{
    std::ostringstream page;
    write_head(page, "berth", "a real-time hybrid simulator, here against its simulated rig");
    page << ".B berth\n.I COMMAND\n.RI [ ARGUMENTS ]\n.SH COMMANDS\n";
    for (const command_entry &command : table) {
        page << ".TP\n\\fBberth " << escaped(command.name) << "\\fR\n" << escaped(command.meaning) << "\n";
    }
    page << ".SH OPTIONS\n.TP\n\\fB\\-\\-version\\fR\nPrint version and commit.\n.TP\n\\fB\\-h\\fR, "
            "\\fB\\-\\-help\\fR\nPrint the commands; behind a command, its options.\n"
         << exit_status
         << ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nIf set, nothing is coloured; in a pipe nothing ever is.\n"
            ".TP\n.B COLUMNS\nThe width at which lines on a terminal are wrapped, instead of its own. Lines in a "
            "pipe\n"
            "are never wrapped.\n"
            ".SH SEE ALSO\n";
    for (const command_entry &command : table) {
        page << ".BR berth\\-" << escaped(command.name) << " (1)" << (&command == &table.back() ? "\n" : ",\n");
    }
    return page.str();
}

std::string man_page(const command_entry &command)
{
    std::ostringstream page;
    write_head(page, "berth-" + command.name, command.meaning);
    page << ".B berth " << escaped(command.name) << "\n";
    bool has_options = false;
    for (const option_entry &option : command.options) {
        if (option.is_positional()) {
            page << (option.is_needed ? ".I " + escaped(option.name) : ".RI [ " + escaped(option.name) + " ]")
                 << "\n";
        }
        has_options = has_options || !option.is_positional();
    }
    page << (has_options ? ".RI [ OPTIONS ]\n" : "");
    for (const bool is_positional : {true, false}) {
        const char *title = is_positional ? ".SH ARGUMENTS\n" : ".SH OPTIONS\n";
        for (const option_entry &option : command.options) {
            if (option.is_positional() == is_positional) {
                page << title;
                write_option(page, option);
                title = "";
            }
        }
    }
    page << exit_status << ".SH SEE ALSO\n.BR berth (1)\n";
    return page.str();
}

} // namespace berth
