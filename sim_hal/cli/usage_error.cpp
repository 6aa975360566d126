#include "usage_error.h"

#include <algorithm>
#include <sstream>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/names.h"
#include "compensation_choice.h"

namespace berth
{

namespace
{

std::vector<std::string> names_of_subcommands(const CLI::App &app)
{
    std::vector<std::string> names;
    for (const CLI::App *const known : app.get_subcommands(nullptr)) {
        names.push_back(known->get_name());
    }
    return names;
}

bool is_one_of(const std::vector<std::string> &names, const std::string &name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

std::string no_subcommand(const std::vector<std::string> &names, const std::vector<std::string> &words)
{
    std::string message = words[0] + ": no such subcommand; ";
    if (words.size() > 1 && is_one_of(names, words[1])) {
        message += "it stands first: berth " + words[1] + " " + words[0] + "; ";
    } else if (const std::string nearest = near_name(names, words[0]); !nearest.empty()) {
        message += "did you mean " + nearest + "? ";
    }
    message += "there are";
    for (const std::string &name : names) {
        message += (name == names.front() ? " " : ", ") + name;
    }
    return message;
}

/* A setting of the rig as people write it; empty: all are as they must be. */
std::string wrong_setting(const std::vector<std::string> &words)
{
    for (std::size_t i = 1; i < words.size(); i++) {
        const std::string &word = words[i];
        const std::size_t name_at = word.find_first_not_of('-');
        const std::size_t equals = word.find('=');
        const bool is_set = words[i - 1] == "--set";
        const bool has_blank =
            is_set && equals == std::string::npos && i + 1 < words.size() && words[i + 1][0] != '-';
        if (has_blank) {
            return "--set " + word + " " + words[i + 1] +
                   ": must look like section.key=value, as object.mass_kg=40, without blanks";
        }
        if (is_set || equals == std::string::npos || name_at == std::string::npos) {
            continue;
        }
        const std::string key = word.substr(name_at, equals - name_at);
        if (key.find('.') != std::string::npos && find_key(key) != nullptr) {
            return word + ": is a key of the rig; write --set " + word.substr(name_at);
        }
    }
    return "";
}

/* "--set=robot.clock=2" -> "--set" */
std::string name_of(const std::string &word)
{
    return word.substr(0, word.find('='));
}

std::vector<std::string> options_of(const CLI::App &command)
{
    std::vector<std::string> names;
    for (const CLI::Option *const option : command.get_options()) {
        for (const std::string &name : option->get_lnames()) {
            names.push_back("--" + name);
        }
    }
    return names;
}

/* "; did you mean --version?", of "--verison" and of "-v", or nothing. */
std::string did_you_mean_option(const std::vector<std::string> &options, const std::string &word)
{
    const auto letters_of = [](const std::string &name) {
        return name.substr(std::min(name.find_first_not_of('-'), name.size()));
    };
    std::vector<std::string> names;
    names.reserve(options.size());
    for (const std::string &option : options) {
        names.push_back(letters_of(option));
    }
    const std::string letters = letters_of(name_of(word));
    const std::string near = letters.empty() ? "" : near_name(names, letters);
    return near.empty() ? "" : "; did you mean --" + near + "?";
}

/* "; berth eigen has it", of an option of other subcommands; empty: none has it. */
std::string who_has(const CLI::App &app, const std::string &option)
{
    std::string list;
    for (const CLI::App *const command : app.get_subcommands(nullptr)) {
        if (is_one_of(options_of(*command), option)) {
            list += (list.empty() ? "" : ", ") + command->get_name();
        }
    }
    return list.empty() ? "" : "; these have it: " + list;
}

/* "; did you mean --object? berth init has it", of an option that is like one of another subcommand. */
std::string near_option_elsewhere(const CLI::App &app, const std::string &option)
{
    std::vector<std::string> all;
    for (const CLI::App *const command : app.get_subcommands(nullptr)) {
        const std::vector<std::string> names = options_of(*command);
        all.insert(all.end(), names.begin(), names.end());
    }
    const std::string near = near_name(all, option);
    return near.empty() ? "" : "; did you mean " + near + "?" + who_has(app, near).substr(1);
}

/* The value of --with that stands where the rig has to, or behind it; empty: none does. */
std::string stray_compensation(const CLI::App &command, const std::vector<std::string> &words)
{
    std::vector<std::string> taken = words;
    for (const CLI::Option *const option : command.get_options()) {
        if (option->get_positional()) {
            taken.insert(taken.end(), option->results().begin(), option->results().end());
        }
    }
    const auto stray = std::find_if(taken.begin(), taken.end(), is_compensation);
    return is_one_of(options_of(command), "--with") && stray != taken.end() ? *stray : "";
}

/* "RIG", or "nothing": the words that a subcommand takes beside its options. */
std::string words_taken(const CLI::App &command)
{
    std::string names;
    for (const CLI::Option *const option : command.get_options()) {
        if (option->get_positional()) {
            names += (names.empty() ? "" : " ") + option->get_name(true);
        }
    }
    return names.empty() ? "nothing" : names;
}

/* An option that the subcommand does not have, or words beyond those that it takes. */
std::string unexpected(const CLI::App &app)
{
    const CLI::App &command = *app.get_subcommands().front();
    const std::string called = "berth " + command.get_name();
    const std::vector<std::string> words = app.remaining(true); /* the first of them is what is wrong */
    if (words[0][0] == '-') {
        const std::string option = name_of(words[0]);
        const std::string near = did_you_mean_option(options_of(command), option);
        const std::string elsewhere = who_has(app, option);
        return option + ": " + called + " has no such option" +
               (!near.empty()        ? near
                : !elsewhere.empty() ? elsewhere
                                     : near_option_elsewhere(app, option));
    }
    if (const std::string stray = stray_compensation(command, words); !stray.empty()) {
        return compensation_for_rig(stray);
    }
    std::string message;
    for (const std::string &word : words) {
        message += (message.empty() ? "" : " ") + word;
    }
    return message + (words.size() > 1 ? ": too many words; " : ": one word too many; ") + called + " takes " +
           words_taken(command);
}

/* An option where the subcommand has to be. */
std::string option_comes_first(const CLI::App &app, const std::vector<std::string> &words)
{
    const std::string option = name_of(words[0]);
    const std::vector<std::string> names = names_of_subcommands(app);
    const auto subcommand =
        std::find_if(words.begin(), words.end(), [&](const auto &word) { return is_one_of(names, word); });
    std::vector<std::string> known = options_of(app);
    if (subcommand == words.end()) {
        return option + ": there is no such option; a subcommand comes first, as berth run ess" +
               did_you_mean_option(known, words[0]);
    }
    const std::vector<std::string> of_subcommand = options_of(*app.get_subcommand(*subcommand));
    if (!is_one_of(of_subcommand, option)) {
        known.insert(known.end(), of_subcommand.begin(), of_subcommand.end());
        return option + ": there is no such option" + did_you_mean_option(known, words[0]);
    }
    return words[0] + ": options stand behind the subcommand, as berth " + *subcommand + " ... " + words[0];
}

/* "--object: walll not in {gripped,contact,beam,none}", and which of them is near. */
std::string with_near_word(const std::string &message)
{
    const std::string between = " not in {";
    const std::size_t at = message.find(between);
    const std::size_t colon = message.rfind(": ", at);
    if (at == std::string::npos || colon == std::string::npos) {
        return message;
    }
    std::vector<std::string> words;
    std::istringstream list(message.substr(at + between.size(), message.rfind('}') - at - between.size()));
    for (std::string word; std::getline(list, word, ',');) {
        words.push_back(word);
    }
    return message + did_you_mean(words, message.substr(colon + 2, at - colon - 2));
}

/* What the command still needs, and what that is. */
std::string missing(const CLI::App &app, const CLI::ParseError &error)
{
    const std::vector<CLI::App *> chosen = app.get_subcommands();
    if (chosen.empty()) {
        return error.what();
    }
    for (const CLI::Option *const option : chosen.front()->get_options()) {
        if (option->get_required() && option->count() == 0) {
            return option->get_name(option->get_positional()) + " is missing: " + option->get_description();
        }
    }
    return error.what();
}

} // namespace

std::string usage_error(const CLI::App &app, const CLI::ParseError &error, const std::vector<std::string> &words)
{
    const std::vector<std::string> names = names_of_subcommands(app);
    if (words.empty()) {
        return error.what();
    }
    const std::string &first = words[0];
    if (first[0] == '-') {
        return option_comes_first(app, words);
    }
    if (!is_one_of(names, first)) {
        return no_subcommand(names, words);
    }
    std::string setting = wrong_setting(words);
    if (!setting.empty()) {
        return setting;
    }
    if (dynamic_cast<const CLI::RequiredError *>(&error) != nullptr) {
        return missing(app, error);
    }
    return dynamic_cast<const CLI::ExtrasError *>(&error) != nullptr ? unexpected(app)
                                                                     : with_near_word(error.what());
}

} // namespace berth
