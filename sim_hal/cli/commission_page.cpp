#include "commission_page.h"

#include "short_number.h"

namespace berth
{

namespace
{

constexpr const char *page_head = R"page(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>berth: commissioning</title>
<style>
:root { color-scheme: light dark; --line: light-dark(#DCE0E3, #333B42); --quiet: light-dark(#555E66, #A3ACB4); }
body { font: 15px/1.5 system-ui, "Segoe UI", "Liberation Sans", "DejaVu Sans", sans-serif; margin: 1.5rem auto;
  max-width: 60rem; padding: 0 1rem; color: light-dark(#1B2025, #E4E8EB); background: light-dark(#FFFFFF, #14181C); }
h1 { font-size: 28px; font-weight: 600; margin: 0; }
h2 { font-size: 18px; font-weight: 600; margin: 34px 0 4px; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; }
th, td { border-bottom: 1px solid var(--line); padding: .3rem .6rem; text-align: left; }
th { color: var(--quiet); font-weight: 600; }
.number { font-variant-numeric: tabular-nums; text-align: right; }
.passed { color: light-dark(#00629B, #5FB4EA); font-weight: 600; }
.failed, .waived, .unjudged { color: light-dark(#B84A00, #F38B4A); font-weight: 600; }
.quiet { color: var(--quiet); }
</style>
)page";

std::string escaped(const std::string &text)
{
    std::string made;
    for (const char c : text) {
        made += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    }
    return made;
}

std::string unit_behind(const stage_value &value)
{
    return value.unit == "1" ? std::string() : " " + value.unit;
}

std::string cell(const std::string &text)
{
    return "<td class=\"number\">" + escaped(text) + "</td>";
}

std::string row_of(const stage_value &value)
{
    return "<tr><td>" + escaped(value.name) + "</td>" + cell(four_digits(value.measured) + unit_behind(value)) +
           cell(value.uncertainty ? "± " + four_digits(*value.uncertainty) : "") +
           cell(value.assumed ? four_digits(*value.assumed) + unit_behind(value) : "") + "</tr>\n";
}

std::string section_of(const commissioning &record, stage stage, const std::string &configuration)
{
    const auto place = static_cast<std::size_t>(stage);
    std::string text = "<h2>" + std::string(stage_names[place]) + "</h2>\n<p class=\"quiet\">" +
                       std::string(stage_meanings[place]) + "</p>\n";
    const stage_entry *const entry = newest_entry(record, stage);
    if (entry == nullptr) {
        return text + "<p>not run</p>\n";
    }
    const std::string outcome(outcome_names[static_cast<std::size_t>(entry->outcome)]);
    text +=
        "<p><span class=\"" + outcome + "\">" + outcome + "</span>" +
        (is_done(record, stage, configuration) || entry->outcome == stage_outcome::failed ? ""
                                                                                          : ", to be run again") +
        ": " + escaped(entry->because) + " <span class=\"quiet\">" + escaped(entry->time) + "</span></p>\n";
    if (!entry->values.empty()) {
        text += "<div class=\"wide\"><table><tr><th></th><th class=\"number\">measured</th><th class=\"number\">95 "
                "%</th><th class=\"number\">assumed</th></tr>\n";
        for (const stage_value &value : entry->values) {
            text += row_of(value);
        }
        text += "</table></div>\n";
    }
    return text;
}

} // namespace

std::string words_of(const stage_value &value)
{
    std::string words = value.name + " " + four_digits(value.measured) + unit_behind(value);
    if (value.uncertainty) {
        words += " +- " + four_digits(*value.uncertainty);
    }
    if (value.assumed) {
        words += ", assumed " + four_digits(*value.assumed) + unit_behind(value);
    }
    return words;
}

std::string commission_page(const commissioning &record, const std::string &configuration)
{
    std::string text = page_head;
    text += "<h1>Commissioning of " + escaped(record.rig) + "</h1>\n<p>On the " +
            std::string(record.place == commissioning_place::target ? "target" : "simulated rig") +
            ". What was measured, beside what the rig file assumes.</p>\n";
    for (std::size_t i = 0; i < stage_names.size(); i++) {
        text += section_of(record, static_cast<stage>(i), configuration);
    }
    return text + "</html>\n";
}

} // namespace berth
